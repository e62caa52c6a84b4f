// Every error of the library, at each of its calls.  Then the station's servo loop in the arm's
// thread: real threads, so that ThreadSanitizer has something to see.  What counts here is order,
// not time.
#include <atomic>
#include <chrono>
#include <set>
#include <thread>

#include "common/realtime/steady_clock.h"
#include "tests/devices/openhaptics/hd_bench.h"
#include "tests/station/answered_servo.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

class OpenHapticsErrors : public ArmTest {
 protected:
  /// All error codes, and one that is not documented.
  static std::vector<hd::Code> Codes() {
    std::vector<hd::Code> codes{0x9999};
    for (const hd::ErrorText& text : hd::ErrorTexts()) {
      if (text.code != hd::kSuccess) codes.push_back(text.code);
    }
    return codes;
  }
  static std::string NameOf(hd::Code code) { return hd::Describe({code, 1, 0}); }
};

TEST_F(OpenHapticsErrors, WhileItOpensEndInAMessageOrInAnArmThatIsInOrder) {
  { OpenHapticsDevice arm(Options()); }
  int calls = 0;
  for (const std::string& function : fake.Calls()) {
    ++calls;
    if (function == "hdScheduleSynchronous") break;  // the device is open from here on
  }
  std::set<std::string> failed;
  for (int nth = 1; nth <= calls; ++nth) {
    for (const hd::Code code : Codes()) {
      fake.Reset({});
      fake.Fail(kAnyFunction, nth, code);
      const std::string error = OpeningError();
      SCOPED_TRACE(std::to_string(nth) + ": " + NameOf(code));
      EXPECT_FALSE(fake.FailurePending());
      EXPECT_FALSE(fake.running());
      EXPECT_FALSE(fake.motors_on());
      EXPECT_FALSE(fake.opened());
      if (!error.empty()) {
        EXPECT_THAT(error, HasSubstr("openhaptics: "));
        failed.insert(error);
      }
    }
  }
  EXPECT_GT(failed.size(), 5 * Codes().size()) << "most calls' errors are told, each in its words";
}

/// From the first tick into contact: after any error no frame has force until the ramp, the force
/// never rises by a step, and no rule of the library is broken.
TEST_F(OpenHapticsErrors, FromTheFirstTickOnNeverGiveAStepOfForce) {
  int calls = 0;
  {
    ArmBench bench(fake, Options());
    ASSERT_TRUE(bench.RunUntilForce());
    calls = static_cast<int>(fake.Calls().size());
  }
  int first = 0;
  for (const std::string& function : fake.Calls()) {
    ++first;
    if (function == "hdScheduleSynchronous") break;
  }
  int tried = 0;
  // A prime stride tries every kind of call, in ticks all along the way.
  for (int nth = first; nth <= calls; nth += 7) {
    const auto codes = Codes();
    const hd::Code code = codes[static_cast<std::size_t>(tried++) % codes.size()];
    SCOPED_TRACE(std::to_string(nth) + ": " + NameOf(code));
    fake.Reset({});
    fake.Fail(kAnyFunction, nth, code);
    ArmBench bench(fake, Options());
    RunWithoutAStep(bench, 500);
    EXPECT_FALSE(fake.FailurePending());
    if (HasFailure()) return;
  }
  EXPECT_GT(tried, 300);
}

/// For each function that a tick calls: what each class of error does in contact.
TEST_F(OpenHapticsErrors, InContactTakeTheForceAwayWithinOneFrameAndGiveItBackAsTheirClassAllows) {
  const std::vector<std::string> functions = {"hdBeginFrame", "hdEndFrame",
                                              "hdGetDoublev", "hdGetIntegerv",
                                              "hdGetError",   "hdGetSchedulerTimeStamp",
                                              "hdSetDoublev"};
  int tried = 0;
  for (const std::string& function : functions) {
    for (const hd::Code code : Codes()) {
      SCOPED_TRACE(function + ": " + NameOf(code));
      fake.Reset({});
      ArmBench bench(fake, Options());
      ASSERT_TRUE(bench.RunUntilForce());
      bench.news.clear();
      fake.Fail(function, 1, code);
      bench.Run(1);
      EXPECT_FALSE(fake.FailurePending());
      bench.Run(1);
      EXPECT_EQ(bench.force(), 0.0);
      EXPECT_FALSE(fake.Frames().back().force_set);
      bench.Run(50);
      EXPECT_EQ(bench.force(), 0.0);
      EXPECT_THAT(bench.news, HasSubstr(hd::Describe({code, 1, 0})));
      const hd::ErrorClass error_class = hd::ClassOf(code);
      EXPECT_EQ(fake.motors_on(), error_class == hd::ErrorClass::kForce);
      const bool comes_back =
          error_class == hd::ErrorClass::kForce || error_class == hd::ErrorClass::kWarm;
      EXPECT_EQ(bench.RunUntilForce(5000), comes_back);
      EXPECT_EQ(bench.force() > 0.0, comes_back);
      ++tried;
    }
  }
  EXPECT_EQ(tried, 7 * 22);
}

TEST_F(OpenHapticsErrors, OfWhatIsAskedTenTimesASecondCountAsWell) {
  for (const hd::Code code : Codes()) {
    SCOPED_TRACE(NameOf(code));
    fake.Reset({});
    ArmBench bench(fake, Options());
    ASSERT_TRUE(bench.RunUntilForce());
    fake.Fail("hdGetBooleanv", 1, code);
    while (fake.FailurePending()) bench.Run(1);
    const hd::ErrorClass error_class = hd::ClassOf(code);
    // A query that the arm does not know is not repeated, and no reason to switch the force off.
    const bool tolerated = error_class == hd::ErrorClass::kUse;
    EXPECT_EQ(bench.force() > 0.0, tolerated);
    EXPECT_EQ(bench.RunUntilForce(5000), error_class != hd::ErrorClass::kFatal);
  }
}

TEST_F(OpenHapticsErrors, OfCalibrationLeaveTheMotorsOff) {
  const FakeHdSetup setup{.calibration = hd::kCalibrationNeedsUpdate};
  for (const std::string function :
       {"hdMakeCurrentDevice", "hdCheckCalibration", "hdUpdateCalibration"}) {
    for (const hd::Code code : Codes()) {
      SCOPED_TRACE(function + ": " + NameOf(code));
      fake.Reset(setup);
      ArmBench bench(fake, Options());
      fake.Fail(function, 1, code);
      while (fake.FailurePending()) bench.Run(1);
      EXPECT_FALSE(fake.motors_on());
      EXPECT_EQ(bench.force(), 0.0);
      const hd::ErrorClass error_class = hd::ClassOf(code);
      const bool passes =
          error_class == hd::ErrorClass::kForce || error_class == hd::ErrorClass::kWarm;
      EXPECT_EQ(bench.RunUntilForce(), passes) << "calibration is tried again";
      EXPECT_THAT(bench.news, HasSubstr(hd::Describe({code, 1, 0})));
    }
  }
}

TEST_F(OpenHapticsErrors, WhileTheMotorsAreSwitchedAndWhileItStopsEndWithThemOff) {
  for (const std::string function : {"hdEnable", "hdDisable", "hdScheduleSynchronous",
                                     "hdStopScheduler", "hdUnschedule", "hdDisableDevice"}) {
    for (const hd::Code code : Codes()) {
      SCOPED_TRACE(function + ": " + NameOf(code));
      fake.Reset({});
      {
        ArmBench bench(fake, Options());
        ASSERT_TRUE(function == "hdEnable" || bench.RunUntilForce());
        fake.Fail(function, 1, code);
        if (function == "hdEnable") {
          while (fake.FailurePending()) bench.Run(1);
        }
        bench.arm.StopTicks();
        EXPECT_FALSE(fake.running());
        EXPECT_FALSE(fake.motors_on()) << "before the arm is closed";
      }
      EXPECT_FALSE(fake.FailurePending());
      EXPECT_FALSE(fake.opened());
    }
  }
}

TEST_F(OpenHapticsErrors, WithoutEndDoNotHangATick) {
  ArmBench bench(fake, Options());
  ASSERT_TRUE(bench.RunUntilForce());
  fake.endless_error = hd::kForceError;
  bench.Run(3);
  EXPECT_EQ(bench.force(), 0.0);
  fake.endless_error = hd::kSuccess;
  EXPECT_TRUE(bench.RunUntilForce());
}

using std::chrono::milliseconds;

class OpenHapticsRealtime : public ArmTest {
 protected:
  void SetUp() override { fake.Reset({.real_time = true}); }
};

using LiveStation = AnsweredServo<OpenHapticsDevice>;

TEST_F(OpenHapticsRealtime, TicksInTheArmsThreadAndSendsAtMostAThousandPosesASecond) {
  DeviceOptions options = Options();
  options.rate_Hz = 4000.0;
  LiveStation station(options);
  station.core.EnableForces(true);
  station.servo.SetPath(&station.path);
  ASSERT_TRUE(station.AnswerUntil([&] { return station.snapshot.sent >= 100; }));
  station.servo.Stop();
  const StationTotals& totals = station.core.totals();
  EXPECT_NEAR(static_cast<double>(totals.ticks), 4.0 * static_cast<double>(totals.sent), 4.0);
}

TEST_F(OpenHapticsRealtime, RendersTheForceAndTakesItOutBeforeItStops) {
  LiveStation station(Options());
  station.core.EnableForces(true);
  station.servo.SetPath(&station.path);
  ASSERT_TRUE(station.AnswerUntil([&] { return fake.MotorForce() > 0.2; }));
  station.servo.SetPath(nullptr);  // while the arm ticks
  station.servo.SetPath(&station.path);
  ASSERT_TRUE(station.AnswerUntil([&] { return fake.MotorForce() > 0.2; }));
  station.servo.Stop();
  EXPECT_FALSE(fake.running());
  EXPECT_FALSE(station.core.renders_force());
  EXPECT_FALSE(fake.Frames().back().force_set && fake.Frames().back().force_N[1] > 0.0);
}

TEST_F(OpenHapticsRealtime, NeedsTheButtonHeldForForcesAndNotOneThatIsStuck) {
  LiveStation station(Options());
  station.servo.EnableForcesByButton();
  fake.arm->buttons = 1;
  station.servo.SetPath(&station.path);
  ASSERT_TRUE(
      station.AnswerUntil([&] { return station.device.State().output == OutputGate::State::kOn; }));
  const std::uint64_t ticks = fake.arm->ticks;
  ASSERT_TRUE(station.AnswerUntil([&] { return fake.arm->ticks > ticks + 300; }));
  EXPECT_EQ(fake.arm->most_force_N, 0.0) << "it has been down since the start";
  fake.arm->buttons = 0;
  ASSERT_TRUE(station.AnswerUntil([&] { return station.device.State().buttons == 0; }));
  fake.arm->buttons = 1;
  ASSERT_TRUE(station.AnswerUntil([&] { return fake.MotorForce() > 0.2; }));
  fake.arm->buttons = 0;
  ASSERT_TRUE(station.AnswerUntil([&] { return fake.MotorForce() == 0.0; }));
}

TEST_F(OpenHapticsRealtime, EndsWhereTheArmsSchedulerHasDied) {
  LiveStation station(Options());
  station.core.EnableForces(true);
  station.servo.SetPath(&station.path);
  ASSERT_TRUE(station.AnswerUntil([&] { return fake.MotorForce() > 0.2; }));
  fake.Die();
  ASSERT_TRUE(Eventually([&] { return fake.MotorForce() == 0.0; }));
  station.servo.SetPath(nullptr);
  station.servo.Stop();
  EXPECT_FALSE(fake.running());
}

TEST_F(OpenHapticsRealtime, LeavesNoForceBehindWhenTheStationsTickHangsNorWhenItComesBack) {
  std::atomic<bool> hang{false};
  std::atomic<bool> hung{false};
  OpenHapticsDevice arm(Options());
  StationCore core(arm);
  core.EnableForces(true);
  arm.StartTicks([&] {
    const std::int64_t now_ns = SteadyNanoseconds();
    const OutgoingPose pose = core.Sense(now_ns, true);
    Reply reply;
    reply.pose_sequence = pose.sequence;
    reply.pose_time_ns = reply.received_ns = now_ns;
    reply.wrench.force = Vec3(0.0, 2.0, 0.0);
    core.Take(reply);
    if (hang) {
      hung = true;
      std::this_thread::sleep_for(milliseconds(200));
    }
    core.Act(now_ns);
  });
  const auto attend = [&] { return arm.Attend(), true; };
  ASSERT_TRUE(Eventually([&] { return attend() && fake.MotorForce() > 0.2; }));
  hang = true;
  ASSERT_TRUE(Eventually([&] { return hung.load(); }));
  // The frame does not end: the amplifier hears nothing, and its watchdog switches the motors off.
  ASSERT_TRUE(Eventually([&] { return fake.MotorForce() == 0.0; }));
  ASSERT_TRUE(Eventually([&] { return attend() && arm.State().long_ticks > 0; }));
  hang = false;
  arm.StopTicks();
  bool late_force = false;
  std::uint64_t last = 0;
  for (const FakeFrame& frame : fake.Frames()) {
    last = frame.tick;
    late_force = frame.force_set && frame.force_N[1] > 0.0;
  }
  EXPECT_GT(last, 0u);
  EXPECT_FALSE(late_force) << "the frame after the hang sets nothing";
}

}  // namespace
}  // namespace palpate::test
