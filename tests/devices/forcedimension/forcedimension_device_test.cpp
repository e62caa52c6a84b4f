// Every error at every call, and every cause for which an arm switches its force off.
#include "devices/forcedimension/forcedimension_device.h"

#include <cmath>

#include "devices/forcedimension/dhd_frame.h"
#include "devices/wrench_limiter.h"
#include "tests/devices/forcedimension/dhd_bench.h"

namespace palpate::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class ForceDimension : public DhdTest {};

TEST_F(ForceDimension, TurnsTheLibrarysFrameIntoTheProjects) {
  EXPECT_TRUE(dhd::ToW(Vec3::UnitX().eval()).isApprox(Vec3::UnitZ())) << "towards the user";
  EXPECT_TRUE(dhd::ToW(Vec3::UnitY().eval()).isApprox(Vec3::UnitX())) << "to the right";
  EXPECT_TRUE(dhd::ToW(Vec3::UnitZ().eval()).isApprox(Vec3::UnitY())) << "up";
  EXPECT_TRUE(dhd::ToD(dhd::ToW(Vec3(1.0, 2.0, 3.0))).isApprox(Vec3(1.0, 2.0, 3.0)));
  EXPECT_TRUE(dhd::ToW(Mat3(Mat3::Identity())).isApprox(Mat3::Identity()));
  // A rotation about the library's z is one about W's y (both point up), by the same angle.
  const Mat3 R_D = Eigen::AngleAxisd(0.3, Vec3::UnitZ()).toRotationMatrix();
  const Mat3 R_W = Eigen::AngleAxisd(0.3, Vec3::UnitY()).toRotationMatrix();
  EXPECT_TRUE(dhd::ToW(R_D).isApprox(R_W));
}

TEST_F(ForceDimension, ReadsPoseVelocityAndButtonsInW) {
  ForceDimensionDevice arm(Options());
  fake.position_m = {0.01, 0.02, 0.03};
  fake.velocity_m_s = {0.1, 0.2, 0.3};
  fake.rotation = {{{0.0, -1.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}}};  // about z, up
  fake.buttons = 5;
  const DeviceSample sample = arm.Read();
  EXPECT_TRUE(sample.X_WH.p.isApprox(Vec3(0.02, 0.03, 0.01)));
  EXPECT_TRUE(sample.V_WH.v.isApprox(Vec3(0.2, 0.3, 0.1)));
  const Quat q(Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitY()));
  EXPECT_NEAR(std::abs(sample.X_WH.q.dot(q)), 1.0, 1e-12);
  EXPECT_EQ(sample.buttons, 5u);
}

TEST_F(ForceDimension, IsOpenedWithWeightCompensatedForcesEnabledAndNoneAsked) {
  ForceDimensionDevice arm(Options());
  EXPECT_TRUE(fake.gravity);
  EXPECT_TRUE(fake.emulates_button) << "the gripper stands in for a button";
  EXPECT_EQ(fake.status[dhd::kStatusForce], 1) << "a sigma's forces wait to be enabled";
  EXPECT_EQ(fake.MotorForce(), 0.0);
  EXPECT_EQ(arm.info().model, "sigma.7 (serial 4711, DHD 3.17.1)");
  EXPECT_EQ(arm.info().torque_axes, 3);
}

TEST_F(ForceDimension, BringsTheWrenchToTheMotorsByARamp) {
  DhdBench bench(fake, Options());
  RunWithoutAStep(bench, 1000);
  EXPECT_NEAR(fake.force_N[2], 2.0, 1e-12) << "up is the library's z";
  EXPECT_NEAR(fake.torque_Nm[0], 0.03, 1e-12) << "and towards the user its x";
  EXPECT_THAT(bench.news, HasSubstr("the arm is ready"));
}

TEST_F(ForceDimension, OfThreeAxesGetsForceAlone) {
  FakeDhdSetup omega;
  omega.type = dhd::kOmega3;
  omega.wrist = omega.active_wrist = omega.active_gripper = false;
  fake.Reset(omega);
  DhdBench bench(fake, Options());
  EXPECT_EQ(bench.arm.info().torque_axes, 0);
  EXPECT_TRUE(bench.RunUntilForce());
  EXPECT_THAT(fake.Calls(), Not(testing::Contains("dhdSetForceAndTorque")));
  EXPECT_TRUE(bench.sample.X_WH.q.isApprox(Quat::Identity()));
  EXPECT_FALSE(fake.emulates_button);
}

TEST_F(ForceDimension, TakesTimeguardAndSaturatedMotorsForNoErrors) {
  for (const int answer : {dhd::kTimeGuard, dhd::kMotorSaturated, 3}) {
    fake.Reset({});
    fake.answer = answer;
    DhdBench bench(fake, Options());
    EXPECT_TRUE(bench.RunUntilForce()) << answer;
    EXPECT_EQ(bench.arm.State().errors, 0u);
    EXPECT_THAT(bench.news, Not(HasSubstr("reports")));
  }
}

TEST_F(ForceDimension, SaysHowToCalibrateAndEnablesItsForcesOnceItIs) {
  fake.Reset({.calibrated = false});
  DhdBench bench(fake, Options());
  bench.Run(500);
  EXPECT_EQ(fake.MotorForce(), 0.0);
  EXPECT_EQ(bench.sample.status, kDeviceFault | kDeviceCalibrating);
  EXPECT_THAT(bench.news, HasSubstr("calibration pit"));
  EXPECT_STREQ(bench.arm.activity(), "to be calibrated");
  fake.status[dhd::kStatusReset] = 0;
  EXPECT_TRUE(bench.RunUntilForce());
}

TEST_F(ForceDimension, IsCalibratedAnewWhereThatIsAskedFor) {
  DeviceOptions options = Options();
  options.calibrate = true;
  DhdBench bench(fake, options);
  bench.Run(100);
  EXPECT_EQ(fake.status[dhd::kStatusReset], 1);
  EXPECT_EQ(fake.MotorForce(), 0.0);
}

TEST_F(ForceDimension, IsFoundByItsSerialNumberAlone) {
  DeviceOptions options = Options();
  options.arm = "4711";
  EXPECT_EQ(OpeningError(options), "");
  options.arm = "4712";
  EXPECT_THAT(OpeningError(options), HasSubstr("with serial number 4712 cannot be opened"));
  options.arm = "left";
  EXPECT_THAT(OpeningError(options), HasSubstr("--device-name 'left': give the arm's serial"));
}

TEST_F(ForceDimension, EndsWithItsForcesOffAndClosed) {
  {
    DhdBench bench(fake, Options());
    ASSERT_TRUE(bench.RunUntilForce());
  }
  EXPECT_EQ(fake.MotorForce(), 0.0);
  EXPECT_THAT(fake.force_N, ElementsAre(0.0, 0.0, 0.0));
  EXPECT_FALSE(fake.open);
}

TEST_F(ForceDimension, HoldsItsPoseAndGivesNothingWhereItsPoseIsNone) {
  const double nan = std::nan("");
  for (const double bad : {nan, 2.0, 1e300, -HUGE_VAL}) {
    fake.Reset({});
    DhdBench bench(fake, Options());
    fake.position_m = {0.0, 0.01, 0.0};
    ASSERT_TRUE(bench.RunUntilForce());
    fake.position_m[1] = bad;
    bench.Run(1);
    EXPECT_EQ(fake.MotorForce(), 0.0);
    EXPECT_EQ(bench.sample.X_WH.p, Vec3(0.01, 0.0, 0.0));
    EXPECT_EQ(bench.sample.V_WH.v, Vec3::Zero());
    EXPECT_EQ(bench.arm.State().bad_poses, 1u);
  }
  fake.Reset({});
  DhdBench bench(fake, Options());
  ASSERT_TRUE(bench.RunUntilForce());
  fake.rotation = {};  // no rotation at all
  bench.Run(1);
  EXPECT_EQ(fake.MotorForce(), 0.0);
}

TEST_F(ForceDimension, BoundsEachArmByItsSheetAndOneThatNobodyKnowsByTheWeakest) {
  const double unknown_N = ForceDimensionSheet(9999).max_force_N;
  for (const int type : {dhd::kOmega3, dhd::kOmega6, dhd::kOmega7, dhd::kDelta3, dhd::kDelta6,
                         dhd::kSigma3, dhd::kSigma7, dhd::kLambda3, dhd::kLambda7, dhd::kFalcon}) {
    const DeviceInfo info = ForceDimensionSheet(type);
    EXPECT_GT(info.max_force_N, unknown_N);
    EXPECT_LE(info.continuous_force_N, info.max_force_N);
    EXPECT_GT(info.workspace_m.minCoeff(), 0.05);
  }
  fake.Reset({.type = 9999});
  DhdBench bench(fake, Options());
  bench.wrench.force = Vec3(0.0, 100.0, 0.0);
  for (int i = 0; i < 2000; ++i) {
    bench.Run(1);
    EXPECT_LE(fake.MotorForce(), unknown_N * (1.0 + 1e-12));
  }
  EXPECT_GT(fake.MotorForce(), 0.9 * unknown_N);
}

class ForceDimensionFaults : public DhdTest {
 protected:
  /// All error codes, and one that is not documented.
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
      // The zero that could not be sent goes out with the next call that succeeds.
      if (function == "dhdSetForceAndTorque") bench.Run(1);
      EXPECT_EQ(fake.MotorForce(), 0.0);
      bench.Run(50);
      EXPECT_EQ(fake.MotorForce(), 0.0);
      EXPECT_THAT(bench.news, HasSubstr(dhd::DescribeError(code)));
      const bool comes_back = dhd::ClassOf(code) == dhd::ErrorClass::kPause;
      EXPECT_EQ(RunWithoutAStep(bench, 1500) > 0.0, comes_back);
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
    EXPECT_EQ(RunWithoutAStep(bench, 1500), 2.0);
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
  fake.Reset({.arms = 0});
  const std::string error = OpeningError();
  EXPECT_THAT(error, HasSubstr("the arm cannot be opened (the library finds 0)"));
  EXPECT_THAT(error, HasSubstr("lsusb -d 1451:"));
}

}  // namespace
}  // namespace palpate::test
