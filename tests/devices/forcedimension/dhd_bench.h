#pragma once

#include "devices/forcedimension/forcedimension_device.h"
#include "tests/devices/arm_bench.h"
#include "tests/devices/forcedimension/fake_dhd.h"

namespace palpate::test {

class DhdTest : public FakeLibraryTest<FakeDhd, ForceDimensionDevice> {
 protected:
  DhdTest() : FakeLibraryTest(PALPATE_FAKE_DHD, dhd::kLibraryVariable, kFakeDhdFunction) {}
};

/// In virtual time; as a station does, it attends to the arm every ten ticks.
struct DhdBench : AnsweredArm<ForceDimensionDevice> {
  DhdBench(FakeDhd& fake_dhd, const DeviceOptions& options)
      : AnsweredArm(options), fake(fake_dhd) {}

  void Run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      now += 1'000'000;
      Tick(now);
      if (i % 10 == 0) Attend();
    }
  }
  double force() { return fake.MotorForce(); }
  bool RunUntilForce(int most_ticks = 2000) { return test::RunUntilForce(*this, most_ticks); }

  FakeDhd& fake;
  std::int64_t now = 1'000'000'000;
};

}  // namespace palpate::test
