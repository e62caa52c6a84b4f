#pragma once

#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

#include <dlfcn.h>
#include <gmock/gmock.h>

#include "client/station/station_core.h"
#include "common/error.h"
#include "devices/device_factory.h"

namespace palpate::test {

/// Loads a fake of a vendor's library; its exported `function` returns the fake.
template <class Fake>
Fake& LoadFake(const char* file, const char* function) {
  void* library = dlopen(file, RTLD_NOW);
  void* symbol = library ? dlsym(library, function) : nullptr;
  if (!symbol) {
    ADD_FAILURE() << dlerror();
    std::abort();
  }
  return *reinterpret_cast<Fake* (*)()>(symbol)();
}

/// Resets the fake library before each test, and fails a test that broke one of its rules.
template <class Fake, class Device>
class FakeLibraryTest : public testing::Test {
 protected:
  /// @param variable  the environment variable by which the driver finds the library.
  FakeLibraryTest(const char* file, const char* variable, const char* function)
      : fake(LoadFake<Fake>(file, function)) {
    setenv(variable, file, 1);
    fake.Reset({});
  }
  void TearDown() override { EXPECT_THAT(fake.Violations(), testing::IsEmpty()); }

  static DeviceOptions Options() {
    DeviceOptions options;
    options.realtime.mode = RealtimeMode::kOff;
    return options;
  }
  static std::string OpeningError(const DeviceOptions& options) {
    try {
      Device device(options);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
  static std::string OpeningError() { return OpeningError(Options()); }

  Fake& fake;
};

/// An arm with a station behind it whose server always answers with one wrench.
template <class Device>
struct AnsweredArm {
  template <class... Arguments>
  explicit AnsweredArm(Arguments&&... arguments) : arm(std::forward<Arguments>(arguments)...) {}

  /// A tick of the station's servo loop at the time `now_ns` of its clock.
  void Tick(std::int64_t now_ns) {
    const OutgoingPose pose = core.Sense(now_ns, true);
    sample = pose.sample;
    if (fault_ends_forces) core.EnableForces((sample.status & kDeviceFault) == 0);
    Reply reply;
    reply.pose_sequence = pose.sequence;
    reply.pose_time_ns = reply.received_ns = now_ns;
    reply.wrench = wrench;
    core.Take(reply);
    core.Act(now_ns);
  }
  void Attend() {
    if (const std::string more = arm.Attend().Lines(); !more.empty()) news += more + "\n";
  }

  Device arm;
  StationCore core{arm};
  Wrench wrench{Vec3(0.0, 2.0, 0.0), Vec3(0.0, 0.0, 0.03)};
  DeviceSample sample;
  std::string news;
  bool fault_ends_forces = true;  ///< as in a station whose device is at fault
};

/// Runs that many ticks, in none of which the force of the motors may rise by more than 0.05 N.
/// Returns the last force [N].  `Bench` has Run(ticks) and force().
template <class Bench>
double RunWithoutAStep(Bench& bench, int ticks) {
  double last = 0.0;
  for (int i = 0; i < ticks; ++i) {
    bench.Run(1);
    EXPECT_LE(bench.force(), last + 0.05) << "tick " << i;
    last = bench.force();
  }
  return last;
}

/// How often `text` occurs in `news`.
inline int CountOf(const std::string& text, const std::string& news) {
  int count = 0;
  for (std::size_t at = 0; (at = news.find(text, at)) != std::string::npos; ++at) ++count;
  return count;
}

/// Runs until the motors render the whole force.  `Bench` is as above.
template <class Bench>
bool RunUntilForce(Bench& bench, int most_ticks = 2000) {
  const double all = bench.wrench.force.norm();
  for (int i = 0; i < most_ticks && bench.force() < all; ++i) bench.Run(1);
  return bench.force() == all;
}

}  // namespace palpate::test
