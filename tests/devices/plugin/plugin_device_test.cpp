// Whatever a third-party driver does wrong: no force, a message that names file, function and
// remedy, and a force that comes back by a ramp.
#include "devices/plugin/plugin_device.h"

#include <cmath>
#include <new>

#include "tests/devices/arm_bench.h"
#include "tests/devices/plugin/wrong_driver.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/complaint.h"
#include "tests/support/eventually.h"

namespace palpate::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

DeviceOptions Options(const std::string& file = PALPATE_WRONG_DRIVER) {
  DeviceOptions options;
  options.name = file;
  return options;
}

class PluginDeviceTest : public testing::Test {
 protected:
  PluginDeviceTest() : arm(LoadFake<WrongArm>(PALPATE_WRONG_DRIVER, kWrongArmFunction)) {
    new (&arm) WrongArm;
  }
  ~PluginDeviceTest() override { EXPECT_FALSE(arm.open) << "it is left open"; }

  WrongArm& arm;
};

/// In virtual time.
struct Bench : AnsweredArm<PluginDevice> {
  explicit Bench(WrongArm& wrong) : AnsweredArm(Options()), told(wrong) {}

  void Run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      arm.Turn([this] { Tick(now += 1'000'000); });
      if (i % 10 == 0) Attend();
    }
  }
  double force() const { return told.force_N; }
  bool RunUntilForce() {
    for (int i = 0; i < 2000 && told.force_N < wrench.force.norm(); ++i) Run(1);
    return std::abs(told.force_N - wrench.force.norm()) < 1e-12;
  }

  WrongArm& told;
  std::int64_t now = 1'000'000'000;
};

TEST_F(PluginDeviceTest, ReadsPosesAndBringsTheWrenchByARamp) {
  Bench bench(arm);
  EXPECT_NEAR(RunWithoutAStep(bench, 1000), 2.0, 1e-12);
  EXPECT_EQ(bench.sample.X_WH.p, Vec3(0.01, 0.0, 0.0));
  EXPECT_EQ(bench.sample.buttons, 1u);
  EXPECT_EQ(bench.sample.V_WH.v, Vec3::Zero());
  EXPECT_THAT(bench.news, HasSubstr("the arm is ready"));
  EXPECT_EQ(bench.arm.info().model, std::string("lever (") + PALPATE_WRONG_DRIVER + ")");
  for (int i = 0; i < 100; ++i) {
    arm.position_m[0] += 1e-4;
    bench.Run(1);
  }
  EXPECT_NEAR(bench.sample.V_WH.v.x(), 0.1, 1e-6) << "by differences";
}

TEST_F(PluginDeviceTest, TakesALengthOfOneToTheDigitsThatPeopleWrite) {
  Bench bench(arm);
  arm.way = WrongArm::kHardlyLongRotation;
  EXPECT_TRUE(bench.RunUntilForce());
  EXPECT_EQ(bench.sample.X_WH.q.norm(), 1.0);
}

TEST_F(PluginDeviceTest, GivesNoForceWhateverTheDriverDoesAndSaysWhatToDo) {
  struct Case {
    WrongArm::Way way;
    int ticks;  ///< until the force is gone
    const char* symbol;
    const char* remedy;
  };
  for (const Case& wrong :
       {Case{WrongArm::kNotFinite, 1, "_read", "position_m that is not finite"},
        Case{WrongArm::kFarAway, 1, "_read", "give metres"},
        Case{WrongArm::kNoRotation, 1, "_read", "normalise it, with w first"},
        Case{WrongArm::kLongRotation, 1, "_read", "normalise it, with w first"},
        Case{WrongArm::kReadFails, 1, "_read", "until it returns 0: the cable is out: plug it in"},
        Case{WrongArm::kSaysNothing, 1, "_read", "palpate_device_last_error does not say why"},
        Case{WrongArm::kReadThrows, 1, "_read", "catch it there"},
        Case{WrongArm::kWriteFails, 1, "_write",
             "until it returns 0: the cable is out: plug it in"},
        Case{WrongArm::kWriteThrows, 1, "_write", "catch it there"},
        Case{WrongArm::kStuck, 10, "_read", "check the connection to the arm"},
        Case{WrongArm::kJumps, 2, "_read", "calibrate the arm"}}) {
    SCOPED_TRACE(wrong.way);
    arm.way = WrongArm::kRight;
    Bench bench(arm);
    ASSERT_TRUE(bench.RunUntilForce());
    bench.news.clear();
    arm.way = wrong.way;
    bench.Run(wrong.ticks);
    EXPECT_EQ(arm.force_N, 0.0);
    EXPECT_TRUE(bench.sample.X_WH.p.head<2>().isApprox(Eigen::Vector2d(0.01, 0.0))) << "held";
    bench.Run(500);
    EXPECT_EQ(arm.force_N, 0.0);
    EXPECT_EQ(bench.sample.status, kDeviceFault);
    EXPECT_THAT(bench.news, AllOf(HasSubstr(PALPATE_WRONG_DRIVER), HasSubstr(wrong.symbol),
                                  HasSubstr(wrong.remedy)));
    EXPECT_EQ(CountOf("\n", bench.news), 1) << "said once: " << bench.news;
    arm.way = WrongArm::kRight;
    RunWithoutAStep(bench, 1000);
    EXPECT_TRUE(bench.RunUntilForce());
  }
}

TEST_F(PluginDeviceTest, SaysToSwitchAnArmOffThatDoesNotStop) {
  Bench bench(arm);
  ASSERT_TRUE(bench.RunUntilForce());
  arm.way = WrongArm::kStopFails;
  bench.Run(100);
  EXPECT_EQ(
      CountOf("palpate_device_stop failed: forces may still be on; switch the arm off", bench.news),
      1);
  arm.way = WrongArm::kRight;
}

TEST_F(PluginDeviceTest, StopsAnArmWhoseDriverHangsAndGoesOnWhenItReturns) {
  for (const WrongArm::Way way : {WrongArm::kReadHangs, WrongArm::kWriteHangs}) {
    arm.way = WrongArm::kRight;
    Bench bench(arm);
    std::atomic<int> ticks{0};
    ASSERT_TRUE(bench.arm.StartTicks([&] {
      bench.Tick(bench.now += 1'000'000);
      ++ticks;
    }));
    const auto renders = [&] {
      bench.Attend();
      return arm.force_N > 1.9;
    };
    ASSERT_TRUE(Eventually(renders)) << bench.news;
    bench.news.clear();
    arm.way = way;
    ASSERT_TRUE(Eventually([&] { return arm.held && arm.force_N == 0.0; }));
    EXPECT_GE(arm.stops, 1);
    const char* symbol =
        way == WrongArm::kReadHangs ? "palpate_device_read did" : "palpate_device_write did";
    EXPECT_TRUE(Eventually([&] {
      bench.Attend();
      return CountOf(symbol, bench.news) == 1;
    })) << bench.news;
    const int before = ticks;
    arm.way = WrongArm::kRight;
    EXPECT_TRUE(Eventually(renders)) << bench.news;
    EXPECT_GT(ticks, before + 100) << "after a pause, by a ramp";
    bench.arm.StopTicks();
    EXPECT_EQ(arm.force_N, 0.0);
  }
}

TEST_F(PluginDeviceTest, NamesTheFunctionThatSlowsTheLoop) {
  Bench bench(arm);
  ASSERT_TRUE(bench.arm.StartTicks([] {}));
  arm.way = WrongArm::kReadIsSlow;
  std::string faults;
  EXPECT_TRUE(Eventually([&] {
    faults += bench.arm.Attend().faults;
    return faults.find("palpate_device_read takes") != std::string::npos;
  })) << faults;
  for (int i = 0; i < 1000; ++i) {
    faults += bench.arm.Attend().faults;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(CountOf("palpate_device_read takes", faults), 1) << faults;
  arm.way = WrongArm::kRight;
  EXPECT_TRUE(Eventually([&] { return !bench.arm.Attend().notes.empty(); }));
}

TEST_F(PluginDeviceTest, LeavesADriverBehindThatHangsToTheEnd) {
  std::atomic<int> ticks{0};
  {
    Bench bench(arm);
    ASSERT_TRUE(bench.arm.StartTicks([&] { ++ticks; }));
    ASSERT_TRUE(Eventually([&] { return ticks > 10; }));
    arm.way = WrongArm::kReadHangs;
    ASSERT_TRUE(Eventually([&] { return arm.held.load(); }));
    bench.arm.StopTicks();
  }
  const int before = ticks;
  EXPECT_TRUE(arm.open) << "nobody closes what still works";
  arm.way = WrongArm::kRight;
  EXPECT_TRUE(Eventually([&] { return !arm.open; })) << "it closes when it returns";
  EXPECT_EQ(ticks, before) << "and does not tick any more";
}

TEST_F(PluginDeviceTest, AllocatesNothingWhateverTheDriverDoes) {
  if (!kCountsAllocations) GTEST_SKIP() << "a sanitizer brings an allocator of its own";
  Bench bench(arm);
  const std::function<void()> tick = [&] { bench.Tick(bench.now += 1'000'000); };
  for (const WrongArm::Way way :
       {WrongArm::kRight, WrongArm::kNotFinite, WrongArm::kReadFails, WrongArm::kWriteFails,
        WrongArm::kStuck, WrongArm::kStopFails, WrongArm::kRight}) {
    arm.way = way;
    const std::uint64_t before = AllocationsOfThisThread();
    for (int i = 0; i < 500; ++i) bench.arm.Turn(tick);
    EXPECT_EQ(AllocationsOfThisThread(), before) << way;
  }
}

std::string OpeningError(const std::string& file = PALPATE_WRONG_DRIVER) {
  return ComplaintOf([&] { MakeDevice(Options(file)); });
}

TEST_F(PluginDeviceTest, SaysWhyAFileIsNoDriver) {
  EXPECT_THAT(OpeningError(PALPATE_NO_DRIVER),
              AllOf(HasSubstr(PALPATE_NO_DRIVER), HasSubstr("build it as a shared object"),
                    HasSubstr("invalid ELF header")));
  EXPECT_THAT(OpeningError("mine.so"), AllOf(HasSubstr("--device mine.so: no driver"),
                                             HasSubstr("./mine.so"), HasSubstr("No such file")));
  EXPECT_THAT(OpeningError(PALPATE_DRIVER_WITHOUT_STOP),
              AllOf(HasSubstr(PALPATE_DRIVER_WITHOUT_STOP),
                    HasSubstr("has no palpate_device_stop; define every function")));
  EXPECT_THAT(
      OpeningError(PALPATE_DRIVER_OF_TOMORROW),
      AllOf(HasSubstr(PALPATE_DRIVER_OF_TOMORROW),
            HasSubstr(
                "palpate_device_abi is 1000 but this version supports 1 to 1; build it with the "),
            HasSubstr("build it with the palpate_device.h of this version")));
  EXPECT_THAT(ComplaintOf([] { CheckDriver(PALPATE_DRIVER_WITHOUT_STOP); }),
              HasSubstr("palpate_device_stop"))
      << "before a server is asked";
}

TEST_F(PluginDeviceTest, SaysWhyAnArmDoesNotOpen) {
  arm.opens = false;
  EXPECT_THAT(OpeningError(), HasSubstr("palpate_device_open failed: no arm is plugged in"));
  arm.way = WrongArm::kSaysNothing;
  EXPECT_THAT(OpeningError(), HasSubstr("palpate_device_last_error does not say why"));
  arm.open_throws = true;
  EXPECT_THAT(OpeningError(), HasSubstr("palpate_device_open threw an exception: catch it there"));
}

TEST_F(PluginDeviceTest, RefusesADataSheetThatIsNone) {
  const palpate_device_info right = arm.info;
  const auto refuses = [&](const char* field, double palpate_device_info::*member, double value) {
    arm.info = right;
    arm.info.*member = value;
    EXPECT_THAT(OpeningError(), AllOf(HasSubstr(PALPATE_WRONG_DRIVER),
                                      HasSubstr(std::string("info.") + field + " is "),
                                      HasSubstr("data sheet, from")))
        << value;
    EXPECT_FALSE(arm.open) << "it is closed again";
  };
  using Info = palpate_device_info;
  for (const double bad : {std::nan(""), 0.0, -1.0, HUGE_VAL, 1e4}) {
    refuses("max_force_N", &Info::max_force_N, bad);
    refuses("thermal_time_s", &Info::thermal_time_s, bad);
  }
  refuses("continuous_force_N", &Info::continuous_force_N, 6.0);
  refuses("continuous_torque_Nm", &Info::continuous_torque_Nm, 0.0);
  refuses("max_torque_Nm", &Info::max_torque_Nm, std::nan(""));
  refuses("position_resolution_m", &Info::position_resolution_m, -1.0);
  arm.info = right;
  arm.info.workspace_m[2] = 300.0;
  EXPECT_THAT(OpeningError(), HasSubstr("info.workspace_m[2] is 300"));
  arm.info = right;
  arm.info.max_torque_Nm = arm.info.continuous_torque_Nm = 0.0;
  EXPECT_EQ(PluginDevice(Options()).info().torque_axes, 0);
}

TEST_F(PluginDeviceTest, BoundsItsForceByTheDataSheet) {
  Bench bench(arm);
  bench.wrench.force = Vec3(0.0, 1e6, 0.0);
  double most = 0.0;
  for (int i = 0; i < 2000; ++i) {
    bench.Run(1);
    most = std::max(most, arm.force_N.load());
  }
  EXPECT_GT(most, 4.5);
  EXPECT_LE(most, 5.0 * (1.0 + 1e-12));
}

}  // namespace
}  // namespace palpate::test
