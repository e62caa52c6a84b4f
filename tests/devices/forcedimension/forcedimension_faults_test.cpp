// Every error at every call, and every cause for which an arm takes its force away.
#include "devices/wrench_limiter.h"
#include "tests/devices/forcedimension/dhd_bench.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

class ForceDimensionFaults : public DhdTest {
 protected:
  /// All but success, and one that nobody knows.
  static std::vector<int> Codes() {
    std::vector<int> codes{9999};
    for (const dhd::ErrorText& text : dhd::ErrorTexts()) {
      if (text.code != 0) codes.push_back(text.code);
    }
    return codes;
  }
};

TEST_F(ForceDimensionFaults, WhileItOpensEndInTheirRemedyAndInAClosedArm) {
  int tried = 0;
  for (const std::string function :
       {"dhdOpen", "dhdGetSystemType", "dhdGetSerialNumber", "dhdSetGravityCompensation",
        "dhdSetForceAndTorque", "dhdGetStatus", "dhdEnableForce"}) {
    for (const int code : Codes()) {
      SCOPED_TRACE(function + ": " + std::to_string(code));
      fake.Reset({});
      fake.Fail(function, 1, code);
      const std::string error = OpeningError();
      EXPECT_FALSE(fake.FailurePending());
      EXPECT_THAT(error, HasSubstr("forcedimension: "));
      EXPECT_THAT(error, HasSubstr(dhd::DescribeError(code)));
      EXPECT_EQ(fake.MotorForce(), 0.0);
      EXPECT_FALSE(fake.open);
      ++tried;
    }
  }
  EXPECT_EQ(tried, 7 * 23);
}

TEST_F(ForceDimensionFaults, InContactTakeTheForceAwayInTheirTickAndGiveItBackAsTheirClassAllows) {
  int tried = 0;
  for (const std::string function : {"dhdGetPositionAndOrientationFrame", "dhdGetLinearVelocity",
                                     "dhdGetStatus", "dhdSetForceAndTorque"}) {
    for (const int code : Codes()) {
      SCOPED_TRACE(function + ": " + std::to_string(code));
      fake.Reset({});
      DhdBench bench(fake, Options());
      ASSERT_TRUE(bench.RunUntilForce());
      bench.news.clear();
      fake.Fail(function, 1, code);
      while (fake.FailurePending()) bench.Run(1);
      // What could not be told at all is zero with the next that can.
      if (function == "dhdSetForceAndTorque") bench.Run(1);
      EXPECT_EQ(fake.MotorForce(), 0.0);
      bench.Run(50);
      EXPECT_EQ(fake.MotorForce(), 0.0);
      EXPECT_THAT(bench.news, HasSubstr(dhd::DescribeError(code)));
      const bool comes_back = dhd::ClassOf(code) == dhd::ErrorClass::kPause;
      double last = 0.0;
      for (int i = 0; i < 1500; ++i) {
        bench.Run(1);
        EXPECT_LE(fake.MotorForce(), last + 0.05) << "tick " << i;
        last = fake.MotorForce();
      }
      EXPECT_EQ(last > 0.0, comes_back);
      EXPECT_EQ(std::string(bench.arm.activity()) == "arm at fault", !comes_back);
      ++tried;
    }
  }
  EXPECT_EQ(tried, 4 * 23);
}

TEST_F(ForceDimensionFaults, OfWhichTheArmTakesItsForceAwayAreToldAndComeBackByARamp) {
  for (int cause = 0; cause <= 7; ++cause) {
    SCOPED_TRACE(cause);
    fake.Reset({});
    DhdBench bench(fake, Options());
    ASSERT_TRUE(bench.RunUntilForce());
    bench.news.clear();
    fake.TakeForce(cause);
    bench.Run(100);
    const dhd::Condition condition = bench.arm.State().condition;
    EXPECT_NE(condition, dhd::Condition::kReady);
    EXPECT_THAT(bench.news, HasSubstr(dhd::DescribeCondition(condition)));
    EXPECT_STREQ(bench.arm.activity(), dhd::TextOf(condition).name);
    EXPECT_EQ(bench.arm.State().rendered.force, Vec3::Zero()) << "not even told";
    fake.GiveForce();
    double last = 0.0;
    for (int i = 0; i < 1500; ++i) {
      bench.Run(1);
      EXPECT_LE(fake.MotorForce(), last + 0.05) << "tick " << i;
      last = fake.MotorForce();
    }
    EXPECT_EQ(last, 2.0);
  }
}

TEST_F(ForceDimensionFaults, OfItsStatusAreToldEach) {
  const std::tuple<int, int, const char*> faults[] = {
      {dhd::kStatusPower, 0, "switch it on"},
      {dhd::kStatusConnected, 0, "USB cable"},
      {dhd::kStatusStarted, 0, "controller does not run"},
      {dhd::kStatusError, 1, "HapticDesk"},
      {dhd::kStatusReset, 1, "calibration pit"},
      {dhd::kStatusWristInit, 0, "turn the wrist"}};
  for (const auto& [place, value, remedy] : faults) {
    fake.Reset({});
    DhdBench bench(fake, Options());
    ASSERT_TRUE(bench.RunUntilForce());
    fake.status[static_cast<std::size_t>(place)] = value;
    bench.Run(30);
    EXPECT_EQ(fake.MotorForce(), 0.0);
    EXPECT_THAT(bench.news, HasSubstr(remedy));
  }
}

TEST_F(ForceDimensionFaults, ThatComeWithEachTickAreToldOnceASecond) {
  DhdBench bench(fake, Options());
  ASSERT_TRUE(bench.RunUntilForce());
  bench.news.clear();
  for (int i = 0; i < 3000; ++i) {
    fake.Fail("dhdGetLinearVelocity", 1, 7);
    bench.Run(1);
  }
  const int told = CountOf("DHD_ERROR_TIMEOUT", bench.news);
  EXPECT_GE(told, 3);
  EXPECT_LE(told, 4);
}

TEST_F(ForceDimensionFaults, ThatThereIsNoArmAreToldWithHowToFindIt) {
  FakeDhdSetup none;
  none.arms = 0;
  fake.Reset(none);
  const std::string error = OpeningError();
  EXPECT_THAT(error, HasSubstr("the arm does not open (the library sees 0)"));
  EXPECT_THAT(error, HasSubstr("lsusb -d 1451:"));
}

}  // namespace
}  // namespace palpate::test
