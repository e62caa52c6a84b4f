#pragma once

#include <cstdlib>
#include <string>

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/station/station_core.h"
#include "common/error.h"
#include "devices/forcedimension/forcedimension_device.h"
#include "tests/devices/forcedimension/fake_dhd.h"

namespace palpate::test {

inline FakeDhd& LoadFakeDhd() {
  void* library = dlopen(PALPATE_FAKE_DHD, RTLD_NOW);
  if (!library) {
    ADD_FAILURE() << dlerror();
    std::abort();
  }
  return *reinterpret_cast<FakeDhdFunction>(dlsym(library, kFakeDhdFunction))();
}

/// The fake library, as new for each test; a test that violates its rules fails.
class DhdTest : public testing::Test {
 protected:
  DhdTest() { fake.Reset({}); }
  void TearDown() override { EXPECT_THAT(fake.Violations(), testing::IsEmpty()); }

  static ForceDimensionOptions Options() {
    ForceDimensionOptions options;
    options.libraries = {PALPATE_FAKE_DHD};
    return options;
  }
  static std::string OpeningError(const ForceDimensionOptions& options = Options()) {
    try {
      ForceDimensionDevice device(options);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  FakeDhd& fake = LoadFakeDhd();
};

/// An arm with a station behind it whose server always answers with one wrench, in virtual time.
class DhdBench {
 public:
  DhdBench(FakeDhd& fake_dhd, ForceDimensionOptions options) : fake(fake_dhd), arm(options) {}

  void Run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      now += 1'000'000;
      const OutgoingPose pose = core.Sense(now, true);
      sample = pose.sample;
      // As a station does with a device at fault.
      core.EnableForces((sample.status & kDeviceFault) == 0);
      Reply reply;
      reply.pose_sequence = pose.sequence;
      reply.pose_time_ns = reply.received_ns = now;
      reply.wrench = wrench;
      core.Take(reply);
      core.Act(now);
      if (i % 10 == 0) Attend();
    }
  }
  void Attend() {
    if (const std::string more = arm.Attend(); !more.empty()) news += more + "\n";
  }
  bool RunUntilForce(int most_ticks = 2000) {
    for (int i = 0; i < most_ticks && fake.MotorForce() < wrench.force.norm(); ++i) Run(1);
    return fake.MotorForce() == wrench.force.norm();
  }

  FakeDhd& fake;
  ForceDimensionDevice arm;
  StationCore core{arm};
  Wrench wrench{Vec3(0.0, 2.0, 0.0), Vec3(0.0, 0.0, 0.03)};
  DeviceSample sample;
  std::int64_t now = 1'000'000'000;
  std::string news;
};

}  // namespace palpate::test
