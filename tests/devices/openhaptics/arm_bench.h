#pragma once

#include <cstdlib>
#include <memory>
#include <string>

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/station/station_core.h"
#include "common/error.h"
#include "devices/openhaptics/openhaptics_device.h"
#include "tests/devices/openhaptics/fake_hd.h"

namespace palpate::test {

/// The fake library, as new for each test; a test that violates its rules fails.
inline FakeHd& LoadFakeHd() {
  void* library = dlopen(PALPATE_FAKE_HD, RTLD_NOW);
  if (!library) {
    ADD_FAILURE() << dlerror();
    std::abort();
  }
  return *reinterpret_cast<FakeHdFunction>(dlsym(library, kFakeHdFunction))();
}

class ArmTest : public testing::Test {
 protected:
  ArmTest() { fake.Reset({}); }
  void TearDown() override { EXPECT_THAT(fake.Violations(), testing::IsEmpty()); }

  static OpenHapticsOptions Options() {
    OpenHapticsOptions options;
    options.libraries = {PALPATE_FAKE_HD};
    return options;
  }
  static std::string OpeningError(const OpenHapticsOptions& options = Options()) {
    try {
      OpenHapticsDevice device(options);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  FakeHd& fake = LoadFakeHd();
};

/// An arm with a station behind it whose server always answers with one wrench, in virtual time.
class ArmBench {
 public:
  explicit ArmBench(FakeHd& fake_hd, OpenHapticsOptions options) : fake(fake_hd), arm(options) {
    core.EnableForces(true);
    arm.StartTicks([this] {
      now += static_cast<std::int64_t>(1e9 / arm.info().rate_Hz);
      const OutgoingPose pose = core.Sense(now, true);
      sample = pose.sample;
      Reply reply;
      reply.pose_sequence = pose.sequence;
      reply.pose_time_ns = reply.received_ns = now;
      reply.wrench = wrench;
      core.Take(reply);
      core.Act(now);
    });
  }
  ~ArmBench() { arm.StopTicks(); }

  /// Ticks and, as a station does, attends to the arm every ten.
  void Run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      fake.Tick();
      if (i % 10 == 0) Attend();
    }
  }
  void Attend() {
    if (const std::string more = arm.Attend(); !more.empty()) news += more + "\n";
  }
  /// Force that the motors have.
  double force() { return fake.MotorForce(); }
  bool RunUntilForce(int most_ticks = 2000) {
    for (int i = 0; i < most_ticks && force() < wrench.force.norm(); ++i) Run(1);
    return force() == wrench.force.norm();
  }

  FakeHd& fake;
  OpenHapticsDevice arm;
  StationCore core{arm};
  Wrench wrench{Vec3(0.0, 2.0, 0.0), Vec3(0.0, 0.0, 0.03)};
  DeviceSample sample;
  std::int64_t now = 1'000'000'000;
  std::string news;
};

}  // namespace palpate::test
