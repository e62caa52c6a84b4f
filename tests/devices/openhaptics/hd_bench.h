#pragma once

#include "devices/openhaptics/openhaptics_device.h"
#include "tests/devices/arm_bench.h"
#include "tests/devices/openhaptics/fake_hd.h"

namespace palpate::test {

class ArmTest : public FakeLibraryTest<FakeHd, OpenHapticsDevice> {
 protected:
  ArmTest() : FakeLibraryTest(PALPATE_FAKE_HD, hd::kLibraryVariable, kFakeHdFunction) {}
};

/// In virtual time: the library's scheduler ticks when the bench runs.
struct ArmBench : AnsweredArm<OpenHapticsDevice> {
  ArmBench(FakeHd& fake_hd, const DeviceOptions& options) : AnsweredArm(options), fake(fake_hd) {
    fault_ends_forces = false;
    core.EnableForces(true);
    arm.StartTicks([this] {
      now += static_cast<std::int64_t>(1e9 / arm.info().rate_Hz);
      Tick(now);
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
  double force() { return fake.MotorForce(); }
  bool RunUntilForce(int most_ticks = 2000) { return test::RunUntilForce(*this, most_ticks); }

  FakeHd& fake;
  std::int64_t now = 1'000'000'000;
};

}  // namespace palpate::test
