#include "devices/openhaptics/openhaptics_device.h"

#include <algorithm>

#include "common/math/rotation.h"
#include "tests/devices/limiter_support.h"
#include "tests/devices/openhaptics/hd_bench.h"
#include "tests/support/allocation_counter.h"

namespace palpate::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class OpenHapticsDeviceTest : public ArmTest {
 protected:
  /// Index of the first call of `function`; -1: it was not called.
  long Place(const std::string& function) {
    const auto calls = fake.Calls();
    const auto found = std::find(calls.begin(), calls.end(), function);
    return found == calls.end() ? -1 : found - calls.begin();
  }
  void TickAndAttend(OpenHapticsDevice& arm) {
    for (int i = 0; i < 500; ++i) {
      fake.Tick();
      arm.Attend();
    }
  }
  FakeHdSetup setup;
};

// Opening.

TEST_F(OpenHapticsDeviceTest, OpensAndClosesInTheOrderThatTheLibraryAsksFor) {
  { OpenHapticsDevice arm(Options()); }
  long last = -1;
  for (const char* function :
       {"hdInitDevice", "hdMakeCurrentDevice", "hdGetString", "hdDisable", "hdEnable",
        "hdSetSchedulerRate", "hdScheduleAsynchronous", "hdStartScheduler", "hdBeginFrame",
        "hdEndFrame", "hdScheduleSynchronous", "hdStopScheduler", "hdUnschedule",
        "hdDisableDevice"}) {
    EXPECT_GT(Place(function), last) << function;
    last = Place(function);
  }
  EXPECT_EQ(fake.Calls().front(), "hdGetError") << "an error of before is not this arm's";
}

TEST_F(OpenHapticsDeviceTest, ReadsTheArmsDataSheetFromTheArm) {
  OpenHapticsDevice arm(Options());
  const DeviceInfo& info = arm.info();
  EXPECT_EQ(info.model, "Fake arm (serial 0042, driver 1.2, HD 3.0-fake)");
  EXPECT_EQ(info.max_force_N, 8.5);
  EXPECT_EQ(info.continuous_force_N, 1.4);
  EXPECT_DOUBLE_EQ(info.max_torque_Nm, 0.188);
  EXPECT_DOUBLE_EQ(info.continuous_torque_Nm, 0.048);
  EXPECT_TRUE(info.workspace_m.isApprox(Vec3(0.420, 0.315, 0.215)));
  EXPECT_TRUE(info.workspace_centre_m.isApprox(Vec3(0.0, 0.0475, 0.0225)));
  EXPECT_GT(info.position_resolution_m, 0.0) << "the limiter must know of an encoder's step";
  EXPECT_GT(info.rotation_resolution_rad, 0.0);
  EXPECT_FALSE(info.simulated);
  EXPECT_EQ(info.rate_Hz, 1000.0);
}

TEST_F(OpenHapticsDeviceTest, RunsAtTheRateAskedForOrAtTheOneThatTheArmKeeps) {
  DeviceOptions options = Options();
  options.rate_Hz = 4000.0;
  EXPECT_EQ(OpenHapticsDevice(options).info().rate_Hz, 4000.0);
  fake.Reset({.most_rate_Hz = 1000});
  OpenHapticsDevice slow(options);
  EXPECT_EQ(slow.info().rate_Hz, 1000.0);
  EXPECT_THAT(slow.Attend().notes,
              HasSubstr("does not take the rate asked for; it runs at 1000 Hz"));
}

TEST_F(OpenHapticsDeviceTest, FallsBackOnTheNamesOfADefaultArmAndOnNoOther) {
  setup.default_name = false;
  setup.names = {"Default PHANToM"};
  fake.Reset(setup);
  EXPECT_EQ(OpeningError(), "");
  EXPECT_EQ(fake.CallsOf("hdInitDevice"), 3);

  fake.Reset(setup);
  DeviceOptions named = Options();
  named.arm = "left";
  const std::string error = OpeningError(named);
  EXPECT_EQ(fake.CallsOf("hdInitDevice"), 1);
  EXPECT_THAT(error, HasSubstr("tried left"));
  EXPECT_THAT(error, HasSubstr("--device-name must be as in the vendor's set-up program"));
  setup.names = {"left"};
  fake.Reset(setup);
  EXPECT_EQ(OpeningError(named), "");
}

TEST_F(OpenHapticsDeviceTest, SaysWhyTheArmDoesNotOpenAndWhatToDo) {
  const auto error_of = [this](hd::Code code) {
    setup.init_error = code;
    fake.Reset(setup);
    return OpeningError();
  };
  for (const hd::ErrorText& text : hd::ErrorTexts()) {
    if (text.code == hd::kSuccess) continue;
    EXPECT_THAT(error_of(text.code), HasSubstr(text.remedy)) << text.name;
  }
  EXPECT_THAT(error_of(hd::kDeviceFault), HasSubstr("tried the default one, Default Device"));
  EXPECT_THAT(error_of(hd::kCommError), HasSubstr("/dev"));
  EXPECT_THAT(error_of(hd::kInvalidLicense), Not(HasSubstr("/dev")));
  EXPECT_THAT(error_of(hd::kDeviceAlreadyInitiated), HasSubstr("in use"));
  EXPECT_EQ(fake.CallsOf("hdInitDevice"), 1) << "no other name can help";
  setup.init_error = hd::kInvalidLicense;
  fake.Reset(setup);
  fake.Fail("hdInitDevice", 1, hd::kCommError);
  EXPECT_THAT(OpeningError(), HasSubstr("HD_INVALID_LICENSE")) << "the last word, by another name";
}

TEST_F(OpenHapticsDeviceTest, SaysThatTheSchedulerDoesNotTickAndDoesNotWaitForItForEver) {
  fake.Reset({.real_time = true});
  fake.Die();
  EXPECT_THAT(OpeningError(), HasSubstr("scheduler was started but does not run; check"));
  EXPECT_FALSE(fake.opened());
}

TEST_F(OpenHapticsDeviceTest, RefusesAnArmWhoseFiguresBoundNothing) {
  const std::pair<FakeHdSetup, const char*> cases[] = {
      {{.max_force_N = 0.0}, "HD_NOMINAL_MAX_FORCE [N] is 0"},
      {{.max_force_N = 8500.0}, "at most 50"},
      {{.max_force_N = std::nan("")}, "is nan"},
      {{.max_torque_mNm = -1.0}, "HD_NOMINAL_MAX_TORQUE_FORCE"},
      {{.output_dof = 4}, "HD_OUTPUT_DOF is 4"},
      {{.input_dof = 0}, "HD_INPUT_DOF is 0"}};
  for (const auto& [figures, why] : cases) {
    fake.Reset(figures);
    EXPECT_THAT(OpeningError(), HasSubstr(why));
  }
}

TEST_F(OpenHapticsDeviceTest, SaysWhichBoundOfItsOwnTheLibraryDoesNotTake) {
  fake.Reset({.refused_capability = hd::kForceRamping});
  OpenHapticsDevice arm(Options());
  EXPECT_THAT(arm.Attend().notes, HasSubstr("does not take HD_FORCE_RAMPING"));
}

// Calibration.

TEST_F(OpenHapticsDeviceTest, LeavesACalibratedArmAlone) {
  ArmBench bench(fake, Options());
  EXPECT_TRUE(bench.RunUntilForce());
  EXPECT_THAT(fake.Calibrations(), IsEmpty());
}

TEST_F(OpenHapticsDeviceTest, CalibratesOneThatDoesItByItselfOnceItHasBeenMoved) {
  fake.Reset({.calibration = hd::kCalibrationNeedsManualInput});
  ArmBench bench(fake, Options());
  bench.Run(1000);
  EXPECT_THAT(bench.news, HasSubstr("(automatic): move the stylus slowly"));
  EXPECT_TRUE(bench.sample.status & kDeviceCalibrating);
  EXPECT_FALSE(fake.motors_on());
  EXPECT_STREQ(bench.arm.activity(), "calibrating");
  fake.SetCalibration(hd::kCalibrationNeedsUpdate);
  EXPECT_TRUE(bench.RunUntilForce());
  EXPECT_THAT(fake.Calibrations(), ElementsAre(hd::kAuto));
  EXPECT_THAT(bench.news, HasSubstr("calibrated (automatic)"));
  EXPECT_FALSE(bench.sample.status & kDeviceCalibrating);
}

TEST_F(OpenHapticsDeviceTest, AsksForTheInkwellAndCalibratesInIt) {
  fake.Reset({.styles = hd::kInkwell | hd::kEncoderReset,
              .calibration = hd::kCalibrationNeedsManualInput});
  ArmBench bench(fake, Options());
  bench.Run(1000);
  EXPECT_THAT(bench.news, HasSubstr("(inkwell): put the stylus into the inkwell"));
  EXPECT_EQ(bench.force(), 0.0);
  fake.SetCalibration(hd::kCalibrationNeedsUpdate);
  EXPECT_TRUE(bench.RunUntilForce());
  EXPECT_THAT(fake.Calibrations(), ElementsAre(hd::kInkwell));
}

TEST_F(OpenHapticsDeviceTest, ResetsEncodersOnlyWhenAButtonSaysThatTheArmIsInPlace) {
  setup.styles = hd::kEncoderReset;
  for (const hd::Enum status : {hd::kCalibrationNeedsManualInput, hd::kCalibrationNeedsUpdate}) {
    setup.calibration = status;
    fake.Reset(setup);
    ArmBench bench(fake, Options());
    bench.Run(2000);
    EXPECT_THAT(bench.news,
                HasSubstr("reset position (upright, its links at right angles) and press"));
    EXPECT_THAT(fake.Calibrations(), IsEmpty());
    fake.arm->buttons = 1;
    bench.Run(3);
    fake.arm->buttons = 0;
    EXPECT_TRUE(bench.RunUntilForce());
    EXPECT_THAT(fake.Calibrations(), ElementsAre(hd::kEncoderReset));
  }
}

TEST_F(OpenHapticsDeviceTest, CalibratesACalibratedArmWhereTheUserAsksForIt) {
  DeviceOptions options = Options();
  options.calibrate = true;
  for (const hd::Enum style : {hd::kEncoderReset, hd::kAuto, hd::kInkwell}) {
    setup.styles = style;
    fake.Reset(setup);
    ArmBench bench(fake, options);
    bench.Run(500);
    if (style == hd::kInkwell) {
      EXPECT_THAT(fake.Calibrations(), IsEmpty()) << "it is not docked";
      EXPECT_FALSE(fake.motors_on());
      fake.docked = true;
    }
    EXPECT_TRUE(bench.RunUntilForce());
    EXPECT_THAT(fake.Calibrations(), ElementsAre(style));
  }
}

TEST_F(OpenHapticsDeviceTest, StaysOffWhereTheArmNamesNoStyleOfCalibration) {
  fake.Reset({.styles = 0, .calibration = hd::kCalibrationNeedsUpdate});
  ArmBench bench(fake, Options());
  bench.Run(2000);
  EXPECT_THAT(bench.news, HasSubstr("calibrate it with its vendor's program"));
  EXPECT_FALSE(fake.motors_on());
}

// State.

TEST_F(OpenHapticsDeviceTest, ReadsPoseAndVelocityInMetresAndTheScenesAxes) {
  fake.Reset({.held_fast = false});
  const Quat q = RotationExp(Vec3(0.3, -1.1, 0.7));
  fake.rotation_wxyz = {q.w(), q.x(), q.y(), q.z()};
  for (std::size_t i = 0; i < 3; ++i) {
    fake.arm->position_mm[i] = fake.arm->hand_mm[i] = 10.0 + 100.0 * static_cast<double>(i);
  }
  ArmBench bench(fake, Options());
  bench.Run(1);
  EXPECT_TRUE(bench.sample.X_WH.p.isApprox(Vec3(0.010, 0.110, 0.210)));
  EXPECT_LT(RotationLog(bench.sample.X_WH.q * q.conjugate()).norm(), 1e-12);
  fake.arm->hand_mm[0] = 15.0;
  bench.Run(10);
  EXPECT_GT(bench.sample.V_WH.v.x(), 0.01) << "5 mm in some 20 ms";
  EXPECT_LT(bench.sample.V_WH.v.x(), 1.0);
}

TEST_F(OpenHapticsDeviceTest, MakesARotationOfATransformThatIsNotQuiteOne) {
  for (std::size_t i = 0; i < 12; ++i) fake.transform_scale[i] = i % 2 ? 1e-3 : -2e-3;
  fake.transform_scale[3] = fake.transform_scale[7] = fake.transform_scale[11] = 0.0;
  ArmBench bench(fake, Options());
  bench.Run(1);
  EXPECT_NEAR(bench.sample.X_WH.q.norm(), 1.0, 1e-14);
  EXPECT_LT(RotationLog(bench.sample.X_WH.q).norm(), 5e-3);
  EXPECT_EQ(bench.arm.State().bad_poses, 0u);
}

TEST_F(OpenHapticsDeviceTest, MeasuresHowFastTheHandleTurns) {
  ArmBench bench(fake, Options());
  const Vec3 w(0.5, -1.0, 2.0);
  for (int i = 0; i < 100; ++i) {
    const Quat q = RotationExp(1e-3 * i * w);
    fake.rotation_wxyz = {q.w(), q.x(), q.y(), q.z()};
    bench.Run(1);
  }
  EXPECT_LT((bench.sample.V_WH.w - w).norm(), 1e-6);
}

TEST_F(OpenHapticsDeviceTest, HoldsThePoseAndDropsTheForceWhereATransformIsNone) {
  ArmBench bench(fake, Options());
  ASSERT_TRUE(bench.RunUntilForce());
  const Pose before = bench.sample.X_WH;
  fake.transform_scale[5] = std::numeric_limits<double>::quiet_NaN();
  bench.Run(1);
  EXPECT_EQ(bench.force(), 0.0);
  EXPECT_EQ(bench.sample.X_WH.p, before.p);
  EXPECT_TRUE(bench.sample.status & kDeviceFault);
  EXPECT_EQ(bench.arm.State().bad_poses, 1u);
  fake.transform_scale[5] = 0.0;
  EXPECT_TRUE(bench.RunUntilForce());
}

TEST_F(OpenHapticsDeviceTest, TellsButtonsTemperaturesAndTheInkwell) {
  fake.temperature = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
  fake.docked = true;
  ArmBench bench(fake, Options());
  fake.arm->buttons = 5;
  bench.Run(1);
  EXPECT_EQ(bench.sample.buttons, 5u);
  const OpenHapticsState& state = bench.arm.State();
  EXPECT_THAT(state.motor_temperature, ElementsAre(0.1, 0.2, 0.3, 0.4, 0.5, 0.6));
  EXPECT_TRUE(state.docked);
}

TEST_F(OpenHapticsDeviceTest, AsksOnceForWhatAnArmDoesNotHave) {
  fake.Reset({.has_temperature = false, .has_inkwell = false});
  ArmBench bench(fake, Options());
  EXPECT_TRUE(bench.RunUntilForce());
  EXPECT_EQ(fake.CallsOf("hdGetBooleanv"), 1);
  EXPECT_FALSE(bench.arm.State().docked);
}

// Force.

TEST_F(OpenHapticsDeviceTest, GivesTheArmExactlyWhatTheLimiterLetThroughInItsUnits) {
  OpenHapticsDevice arm(Options());
  Wrench wrench{};
  arm.StartTicks([&] { arm.Apply(PassThrough(wrench)); });
  TickAndAttend(arm);
  wrench = {Vec3(1.0, -2.0, 3.0), Vec3(0.010, -0.020, 0.030)};
  fake.Tick();
  const FakeFrame frame = fake.Frames().back();
  EXPECT_TRUE(frame.motors_on);
  EXPECT_THAT(frame.force_N, ElementsAre(1.0, -2.0, 3.0));
  EXPECT_THAT(frame.torque_mNm, ElementsAre(testing::DoubleEq(10.0), testing::DoubleEq(-20.0),
                                            testing::DoubleEq(30.0)));
  EXPECT_EQ(arm.State().rendered.torque, wrench.torque);
  arm.StopTicks();
}

TEST_F(OpenHapticsDeviceTest, SetsNoTorqueWhereNoneIsRenderedAndSaysWhatIsLost) {
  fake.Reset({.output_dof = 3});
  OpenHapticsDevice arm(Options());
  EXPECT_EQ(arm.info().torque_axes, 0);
  Wrench wrench{};
  arm.StartTicks([&] { arm.Apply(PassThrough(wrench)); });
  TickAndAttend(arm);
  wrench = {Vec3(1.0, 0.0, 0.0), Vec3(0.010, 0.0, 0.0)};
  fake.Tick();
  EXPECT_TRUE(fake.Frames().back().force_set);
  EXPECT_FALSE(fake.Frames().back().torque_set);
  EXPECT_EQ(arm.State().rendered.torque.x(), 0.0);
  EXPECT_EQ(arm.State().rendered.force.x(), 1.0);
  arm.StopTicks();
}

TEST_F(OpenHapticsDeviceTest, SetsNothingWhereNobodyComputesAForce) {
  OpenHapticsDevice arm(Options());
  TickAndAttend(arm);
  for (const FakeFrame& frame : fake.Frames()) EXPECT_FALSE(frame.force_set);
  arm.Apply(PassThrough({Vec3(1, 0, 0), Vec3::Zero()}));  // between ticks: no frame is open
  EXPECT_EQ(fake.CallsOf("hdSetDoublev"), 0);
}

TEST_F(OpenHapticsDeviceTest, RendersNothingOnceTheStationsTickStaysOut) {
  ArmBench bench(fake, Options());
  ASSERT_TRUE(bench.RunUntilForce());
  bench.arm.StartTicks([] {});  // a loop that no longer computes anything
  fake.Tick();
  EXPECT_FALSE(fake.Frames().back().force_set);
  EXPECT_EQ(bench.force(), 0.0);
}

TEST_F(OpenHapticsDeviceTest, DoesNotSetAForceThatTookTooLongToCompute) {
  ArmBench bench(fake, Options());
  ASSERT_TRUE(bench.RunUntilForce());
  fake.tick_elapsed_s = 0.5;
  bench.Run(1);
  EXPECT_EQ(bench.force(), 0.0);
  EXPECT_EQ(bench.arm.State().long_ticks, 1u);
  fake.tick_elapsed_s = 0.0;
  bench.Run(1);
  EXPECT_EQ(bench.force(), 0.0) << "it comes back by a ramp";
  EXPECT_TRUE(bench.RunUntilForce());
}

TEST_F(OpenHapticsDeviceTest, LosesTheForceWithinOneFrameWhenItIsUnpluggedInContactAndKeepsItOff) {
  ArmBench bench(fake, Options());
  ASSERT_TRUE(bench.RunUntilForce());
  fake.unplugged = true;
  bench.Run(1);
  EXPECT_EQ(bench.force(), 0.0);
  EXPECT_FALSE(fake.motors_on());
  fake.unplugged = false;
  bench.Run(5000);
  EXPECT_EQ(bench.force(), 0.0) << "nobody knows where a replugged arm is";
  EXPECT_THAT(bench.news, HasSubstr("HD_COMM_ERROR"));
  EXPECT_THAT(bench.news, HasSubstr("check the arm's cable"));
  EXPECT_THAT(bench.news, HasSubstr("forces are off until the station is started again"));
  EXPECT_STREQ(bench.arm.activity(), "arm at fault");
}

TEST_F(OpenHapticsDeviceTest, RestsWhileTheMotorsAreHotAndGoesOnWhenTheyHaveCooled) {
  ArmBench bench(fake, Options());
  bench.wrench.force = Vec3(0.0, 1.0, 0.0);  // warm motors may give it, too
  ASSERT_TRUE(bench.RunUntilForce());
  fake.temperature[2] = 1.0;
  fake.Fail("hdEndFrame", 1, hd::kWarmMotors);
  bench.Run(2);
  EXPECT_EQ(bench.force(), 0.0);
  bench.Run(20000);
  EXPECT_FALSE(fake.motors_on());
  EXPECT_THAT(bench.news, HasSubstr("no force until they have cooled"));
  EXPECT_STREQ(bench.arm.activity(), "motors cooling");
  fake.temperature[2] = 0.5;
  EXPECT_TRUE(bench.RunUntilForce());
}

TEST_F(OpenHapticsDeviceTest, DoesNotTakeAMotorForCoolWhoseTemperatureIsNoNumber) {
  for (const std::size_t motor : {0u, 5u}) {
    fake.Reset({});
    ArmBench bench(fake, Options());
    ASSERT_TRUE(bench.RunUntilForce());
    fake.temperature[motor] = std::numeric_limits<double>::quiet_NaN();
    fake.Fail("hdEndFrame", 1, hd::kWarmMotors);
    bench.Run(20'000);
    EXPECT_FALSE(fake.motors_on()) << motor;
    EXPECT_EQ(bench.sample.motor_temperature,
              *std::ranges::max_element(fake.temperature,
                                        [](double a, double b) { return std::isnan(a) || a < b; }))
        << "the hottest of those that are known";
    fake.temperature[motor] = 0.3;
    EXPECT_TRUE(bench.RunUntilForce());
  }
}

TEST_F(OpenHapticsDeviceTest, TellsAnErrorOfEveryTickOnceASecond) {
  ArmBench bench(fake, Options());
  ASSERT_TRUE(bench.RunUntilForce());
  bench.news.clear();
  for (int i = 0; i < 3000; ++i) {
    fake.Fail("hdEndFrame", 1, hd::kExceededMaxVelocity);
    bench.Run(1);
    bench.Attend();
  }
  EXPECT_EQ(CountOf("EXCEEDED_MAX_VELOCITY", bench.news), 3) << bench.news;
  EXPECT_THAT(bench.news, HasSubstr(" times)"));
}

// Ending.

TEST_F(OpenHapticsDeviceTest, RendersNothingOnceItsTicksStopAndClosesTheArmOnce) {
  {
    ArmBench bench(fake, Options());
    ASSERT_TRUE(bench.RunUntilForce());
    bench.arm.StopTicks();
    EXPECT_FALSE(fake.running());
    EXPECT_FALSE(fake.motors_on());
    EXPECT_FALSE(fake.Frames().back().force_set);
  }
  EXPECT_EQ(fake.CallsOf("hdDisableDevice"), 1);
}

TEST_F(OpenHapticsDeviceTest, AllocatesNothingInATick) {
  ArmBench bench(fake, Options());
  ASSERT_TRUE(bench.RunUntilForce());
  const std::uint64_t before = AllocationsOfThisThread();
  fake.Tick(2000);
  fake.Fail("hdEndFrame", 1, hd::kForceError);
  fake.Tick(2000);
  EXPECT_EQ(AllocationsOfThisThread(), before);
}

}  // namespace
}  // namespace palpate::test
