#include "devices/haply/haply_device.h"

#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/devices/haply/haply_bench.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/complaint.h"
#include "tests/support/eventually.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

class Haply : public testing::Test {
 protected:
  std::string OpeningError(const std::string& id = "") {
    return ComplaintOf([&] { HaplyDevice device(OptionsOf(service, id)); });
  }
  /// Gone from what is sent, and back by a ramp once `mend` is done.
  void ExpectGoneAndBack(HaplyBench& bench, const std::function<void()>& mend) {
    EXPECT_TRUE(bench.Until([&] { return bench.arm.sent_force().isZero(0.0); }));
    EXPECT_NE(bench.sample.status & kDeviceFault, 0u);
    mend();
    double last = 0.0;
    bool steps = false;
    EXPECT_TRUE(bench.Until([&] {
      const double now = bench.arm.sent_force().norm();
      steps = steps || now > last + 0.2;
      last = now;
      return now > 0.9;
    }));
    // The limiter's ramp takes 200 ms; a tick that the machine holds up counts for 2 ms of it.
    EXPECT_FALSE(steps);
  }
  FakeInverseService service;
};

TEST_F(Haply, IsBoundedWithoutTorqueByTheTypeThatTheServiceNames) {
  const HaplyDevice arm(OptionsOf(service));
  EXPECT_EQ(arm.info().model, "Haply inverse3 (049D)");
  EXPECT_EQ(arm.info().force_axes, 3);
  EXPECT_EQ(arm.info().torque_axes, 0);
  EXPECT_LE(arm.info().continuous_force_N, arm.info().max_force_N);
}

TEST_F(Haply, GivesPoseAndButtonsInWAboutTheMiddleOfItsReach) {
  service.SetPosition({0.01, -0.12 - 0.02, 0.15 + 0.03});
  service.SetOrientation({0.6, 0.0, 0.0, 0.8});
  service.buttons = 5;
  HaplyBench bench(service);
  ASSERT_TRUE(bench.Until([&] { return bench.sample.buttons == 5u; }));
  EXPECT_TRUE(bench.sample.X_WH.p.isApprox(Vec3(0.01, 0.03, 0.02), 1e-9));
  EXPECT_NEAR(std::abs(bench.sample.X_WH.q.dot(Quat(0.6, 0.0, 0.8, 0.0))), 1.0, 1e-9);
}

TEST_F(Haply, SendsTheForceAsTheServiceHasItAndSaysWhoItIs) {
  HaplyBench bench(service);
  ASSERT_TRUE(bench.UntilForce());
  EXPECT_TRUE(bench.Until([&] { return service.force()[2] > 0.9; })) << "up is the service's z";
  EXPECT_EQ(service.force()[0], 0.0);
  EXPECT_THAT(service.first_command(), HasSubstr(R"("profile":{"name":"palpate"})"));
  EXPECT_THAT(bench.news, HasSubstr("the device is ready"));
}

TEST_F(Haply, KeepsNoForceWhereTheStationNoLongerTicks) {
  HaplyBench bench(service);
  ASSERT_TRUE(bench.UntilForce());
  EXPECT_TRUE(Eventually([&] { return service.force() == std::array<double, 3>{}; }));
}

TEST_F(Haply, LosesItsForceWithItsServiceAndFindsBothAgain) {
  HaplyBench bench(service);
  ASSERT_TRUE(bench.UntilForce());
  service.Die();
  ExpectGoneAndBack(bench, [&] {
    EXPECT_TRUE(bench.UntilNews("the Inverse Service has gone"));
    EXPECT_TRUE(bench.Until([&] { return std::string(bench.arm.activity()) == "service gone"; }));
    EXPECT_THAT(bench.news, HasSubstr("journalctl -u haply-inverse-service"));
    service.ComeBack();
  });
  EXPECT_TRUE(bench.UntilNews("the Inverse Service is back"));
}

TEST_F(Haply, LosesItsForceWhereTheServiceStallsAndSendsNoOldOneAfterwards) {
  HaplyBench bench(service);
  ASSERT_TRUE(bench.UntilForce());
  service.stalls = true;
  ExpectGoneAndBack(bench, [&] {
    EXPECT_TRUE(bench.UntilNews("does not answer in time"));
    const std::uint64_t before = service.commands;
    service.stalls = false;
    // One force may have been on its way; the next is what is asked for now, and that is nothing.
    EXPECT_TRUE(bench.Until([&] { return service.commands >= before + 2; }));
    EXPECT_EQ(service.force(), (std::array<double, 3>{}));
  });
}

TEST_F(Haply, LosesItsForceWhereRepliesComeTooLate) {
  HaplyBench bench(service);
  ASSERT_TRUE(bench.UntilForce());
  service.delay_ms = 60;
  ExpectGoneAndBack(bench, [&] { service.delay_ms = 0; });
}

TEST_F(Haply, LosesItsForceWithEachLieAndHoldsItsPose) {
  HaplyBench bench(service);
  ASSERT_TRUE(bench.UntilForce());
  const Vec3 held = bench.sample.X_WH.p;
  for (const char* lie :
       {"no JSON", "{}", R"({"inverse3":"no array"})",
        R"({"inverse3":[{"device_id":"other","state":{}}]})",
        R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":1e300}}}]})"}) {
    SCOPED_TRACE(lie);
    service.Lie(lie);
    ExpectGoneAndBack(bench, [&] {
      EXPECT_EQ(bench.sample.X_WH.p, held);
      service.Lie("");
    });
  }
  EXPECT_THAT(bench.news, HasSubstr("has lost the device: check its USB cable"));
}

TEST_F(Haply, LosesItsForceWithItsGripItsCalibrationAndByAJump) {
  HaplyBench bench(service);
  ASSERT_TRUE(bench.UntilForce());
  service.grip_there = false;
  ExpectGoneAndBack(bench, [&] {
    EXPECT_TRUE(bench.UntilNews("the VerseGrip has gone"));
    service.grip_there = true;
  });
  service.calibrated = false;
  ExpectGoneAndBack(bench, [&] {
    EXPECT_TRUE(bench.UntilNews("put the grip on its inkwell"));
    service.calibrated = true;
  });
  service.SetPosition({0.1, -0.12, 0.15});
  ExpectGoneAndBack(bench, [] {});
}

TEST_F(Haply, SaysWhatToDoWhereThereIsNoServiceOrNoDevice) {
  EXPECT_THAT(OpeningError("1234"), HasSubstr("has no device '1234'"));
  service.LieFirst("hello");
  EXPECT_THAT(OpeningError(), HasSubstr("does not speak as the Inverse Service does"));
  service.Die();
  EXPECT_THAT(OpeningError(), HasSubstr("no Inverse Service at ws://127.0.0.1:"));
  EXPECT_THAT(OpeningError(), HasSubstr("PALPATE_HAPLY_SERVICE"));
}

TEST_F(Haply, TakesItsServicesAddressFromTheEnvironment) {
  unsetenv(haply::kServiceVariable);
  EXPECT_EQ(haply::ServiceAddress().port, "10001");
  setenv(haply::kServiceVariable, "ws://arm.lab:8500/", 1);
  EXPECT_EQ(haply::ServiceAddress().host, "arm.lab");
  EXPECT_EQ(haply::ServiceAddress().port, "8500");
  for (const char* bad : {"arm.lab", "ws://:1", "ws://arm:", "ws://arm:x"}) {
    setenv(haply::kServiceVariable, bad, 1);
    EXPECT_THROW(haply::ServiceAddress(), UsageError) << bad;
  }
  unsetenv(haply::kServiceVariable);
}

TEST_F(Haply, AsksForNoMemoryInATick) {
  if (!kCountsAllocations) GTEST_SKIP();
  HaplyDevice arm(OptionsOf(service));
  StationCore core(arm);
  core.Act(SteadyNanoseconds());
  const std::uint64_t before = AllocationsOfThisThread();
  for (int i = 0; i < 100; ++i) {
    core.Sense(SteadyNanoseconds(), true);
    core.Act(SteadyNanoseconds());
  }
  EXPECT_EQ(AllocationsOfThisThread(), before);
}

}  // namespace
}  // namespace palpate::test
