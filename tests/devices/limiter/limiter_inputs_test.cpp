// Each input of the limiter that is out of its range, and the valid one that it may not exceed.
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "devices/wrench_limiter.h"
#include "tests/devices/limiter/limiter_figures.h"

namespace palpate::test {
namespace {

using Change = std::function<void(LimiterInput&, double)>;

constexpr double kDenormal = 5e-324, kHuge = 1e308;

/// A held force of 10 N with a guide's, which the limiter passes whole.
LimiterInput Pressing() {
  LimiterInput in;
  in.wanted = {Vec3(10.0, 0, 0), Vec3(0.1, 0, 0)};
  in.led = {Vec3(1.0, 0, 0), Vec3(0.01, 0, 0)};
  in.silence_s = in.age_s = 0.5e-3;
  in.dt_s = kTick;
  return in;
}

WrenchLimiter Running() {
  WrenchLimiter limiter(PhantomLimits());
  limiter.Enable(true);
  for (int i = 0; i < 300; ++i) limiter.Limit(Pressing());
  return limiter;
}

/// The wrenches of half a second in which that input is changed, by ticks.
std::vector<Wrench> Given(const Change& change, double value) {
  WrenchLimiter limiter = Running();
  std::vector<Wrench> given;
  for (int i = 0; i < 500; ++i) {
    LimiterInput in = Pressing();
    change(in, value);
    given.push_back(limiter.Limit(in).wrench());
  }
  return given;
}

/// Whether `given` is in no tick more than `most`.
testing::AssertionResult IsNoMore(const std::vector<Wrench>& given,
                                  const std::vector<Wrench>& most) {
  for (std::size_t i = 0; i < given.size(); ++i) {
    // False for NaN.
    if (given[i].force.norm() <= most[i].force.norm() &&
        given[i].torque.norm() <= most[i].torque.norm()) {
      continue;
    }
    return testing::AssertionFailure() << i << " ms: " << given[i].force.transpose() << " N beside "
                                       << most[i].force.transpose();
  }
  return testing::AssertionSuccess();
}

struct Row {
  std::string input;
  Change change;
  std::vector<double> out_of_range;
  double worst;  ///< of its range
};

std::vector<Row> Rows() {
  const std::vector<double> no_time = {kNan, kInf, -kInf, -kHuge, -1.0, -kDenormal};
  const std::vector<double> no_number = {kNan, kInf, -kInf};
  std::vector<Row> rows = {
      {"silence", [](LimiterInput& in, double v) { in.silence_s = v; }, no_time,
       AgeStage::kSilenceNone_s},
      {"age", [](LimiterInput& in, double v) { in.age_s = v; }, no_time, AgeStage::kAgeNone_s},
      {"hot motors",
       [](LimiterInput& in, double v) { in.motor_temperature = v; },
       {1.0 + 1e-15, 1.01, 1.2, kHuge, kInf},
       1.0},
      {"unknown motors",
       [](LimiterInput& in, double v) { in.motor_temperature = v; },
       {kNan, -kDenormal, -1.0, -kHuge, -kInf},
       0.0},
      {"wanted force", [](LimiterInput& in, double v) { in.wanted.force.y() = v; }, no_number,
       kHuge},
      {"wanted torque", [](LimiterInput& in, double v) { in.wanted.torque.y() = v; }, no_number,
       kHuge},
      {"led force", [](LimiterInput& in, double v) { in.led.force.y() = v; }, no_number, kHuge},
      {"led torque", [](LimiterInput& in, double v) { in.led.torque.y() = v; }, no_number, kHuge},
      {"position",
       [](LimiterInput& in, double v) { in.X_WH.p.z() = v; },
       {kNan, kInf, -kInf, kHuge, -1001.0},
       1000.0},
      {"rotation",
       [](LimiterInput& in, double v) { in.X_WH.q.w() = v; },
       {kNan, kInf, -kInf, kHuge, 0.0, kDenormal, 2.0},
       1.0}};
  return rows;
}

TEST(LimiterInputs, GiveNoMoreOutOfTheirRangeThanTheWorstInIt) {
  for (const Row& row : Rows()) {
    const std::vector<Wrench> worst = Given(row.change, row.worst);
    for (const double value : row.out_of_range) {
      EXPECT_TRUE(IsNoMore(Given(row.change, value), worst)) << row.input << ' ' << value;
    }
  }
}

TEST(LimiterInputs, LetTheForceFadeWhereTheTimeOfATickIsNone) {
  for (const double none : {kNan, kInf, -kInf, -kHuge, -1e-3, -kDenormal}) {
    const std::vector<Wrench> given = Given([](LimiterInput& in, double v) { in.dt_s = v; }, none);
    EXPECT_TRUE(IsNoMore({given.begin() + 1, given.end()}, {given.begin(), given.end() - 1}))
        << none << ": it rises";
    EXPECT_TRUE(given[10].force.isZero(0.0) && given[10].torque.isZero(0.0)) << none;
  }
}

TEST(LimiterInputs, RaiseNoForceWhereTheTimeOfATickIsNone) {
  for (const double none : {kNan, kInf, -kInf, -kHuge, -1e-3, -kDenormal, kDenormal}) {
    WrenchLimiter limiter(PhantomLimits());
    limiter.Enable(true);
    LimiterInput in = Pressing();
    in.dt_s = none;
    for (int i = 0; i < 1000; ++i) {
      ASSERT_TRUE(limiter.Limit(in).wrench().force.isZero(0.0)) << none << ' ' << i;
    }
  }
}

TEST(LimiterInputs, TakeAForceAwayFromADisabledArmWhateverTheTime) {
  for (const double none : {kNan, kInf, -kInf, -1.0}) {
    WrenchLimiter limiter = Running();
    limiter.Enable(false);
    LimiterInput in = Pressing();
    in.dt_s = none;
    for (int i = 0; i < 30; ++i) limiter.Limit(in);
    EXPECT_TRUE(limiter.Limit(in).wrench().force.isZero(0.0)) << none;
  }
}

TEST(LimiterInputs, ComeBackByARampAfterATimeThatWasNone) {
  WrenchLimiter limiter = Running();
  LimiterInput none = Pressing();
  none.dt_s = kNan;
  double last = limiter.Limit(none).wrench().force.norm();
  EXPECT_GT(last, 8.0) << "one wrong time is hardly felt";
  for (int i = 0; i < 50; ++i) {
    const double now = limiter.Limit(Pressing()).wrench().force.norm();
    EXPECT_LE(now - last, 11.0 * kTick / AgeStage::kRampIn_s + 1e-9);
    last = now;
  }
  EXPECT_NEAR(last, 11.0, 1e-9);
}

TEST(LimiterInputs, DoNotDependOnTheDriversVelocity) {
  const Change change = [](LimiterInput& in, double v) {
    in.V_WH = {Vec3::Constant(v), Vec3::Constant(v)};
  };
  const std::vector<Wrench> still = Given(change, 0.0);
  for (const double v : {kNan, kInf, -kInf, kHuge, -kHuge, kDenormal}) {
    EXPECT_TRUE(IsNoMore(Given(change, v), still)) << v;
    EXPECT_TRUE(IsNoMore(still, Given(change, v))) << v;
  }
}

TEST(LimiterInputs, TakeAStiffnessThatIsNoneForUnknown) {
  // A hand that presses and lets go fast, against a spring that gives more than it took.
  const auto work = [](std::optional<double> stiffness) {
    WrenchLimiter limiter(PhantomLimits());
    limiter.Enable(true);
    if (stiffness) limiter.SetStiffness(*stiffness);
    double sum = 0.0;
    for (int i = 0; i < 2000; ++i) {
      LimiterInput in = Pressing();
      in.led = {};
      in.X_WH.p.x() = -0.004 * std::sin(0.02 * i);
      in.wanted.force.x() = -1200.0 * in.X_WH.p.x();
      sum += limiter.Limit(in).wrench().force.x();
    }
    return sum;
  };
  for (const double none : {kNan, kInf, -kInf, -1000.0, 0.0, -kDenormal, -kHuge}) {
    EXPECT_EQ(work(none), work({})) << none;
  }
}

TEST(LimiterInputs, KeepEachFigureOfADataSheetInItsRange) {
  constexpr double DeviceInfo::*figures[] = {
      &DeviceInfo::max_force_N,           &DeviceInfo::max_torque_Nm,
      &DeviceInfo::continuous_force_N,    &DeviceInfo::continuous_torque_Nm,
      &DeviceInfo::thermal_time_s,        &DeviceInfo::motion_scale,
      &DeviceInfo::position_resolution_m, &DeviceInfo::rotation_resolution_rad};
  for (std::size_t i = 0; i < std::size(figures); ++i) {
    for (const double value : {kNan, kInf, -kInf, -1.0, -kDenormal, kHuge, 1e300}) {
      DeviceInfo info = PhantomPremium30().info;
      info.*figures[i] = value;
      EXPECT_THROW(WrenchLimits::Of(info), Error) << i << ' ' << value;
    }
  }
  for (const auto figure : {&DeviceInfo::max_force_N, &DeviceInfo::continuous_force_N,
                            &DeviceInfo::max_torque_Nm, &DeviceInfo::continuous_torque_Nm,
                            &DeviceInfo::motion_scale, &DeviceInfo::thermal_time_s}) {
    DeviceInfo info = PhantomPremium30().info;
    info.*figure = kDenormal;
    EXPECT_THROW(WrenchLimits::Of(info), Error);
  }
}

TEST(LimiterInputs, KeepTheUsersForceInItsRange) {
  for (const double most_N : {kNan, -kInf, -1.0, 0.0, kDenormal, 1e-308, 1e-9}) {
    EXPECT_THROW(WrenchLimits::Of(PhantomPremium30().info, most_N), Error) << most_N;
  }
}

TEST(LimiterInputs, SayWhatIsOddAboutAMotorTemperature) {
  const auto remark = [](double temperature) {
    WrenchLimiter limiter(PhantomLimits());
    LimiterInput in = Pressing();
    in.motor_temperature = temperature;
    limiter.Limit(in);
    return TemperatureRemark(limiter.counts());
  };
  EXPECT_EQ(remark(0.0), "");
  EXPECT_EQ(remark(1.0), "");
  EXPECT_EQ(remark(1.01), remark(kInf));
  EXPECT_EQ(remark(-0.1), remark(-kInf));
  EXPECT_NE(remark(1.01), remark(-0.1));
  EXPECT_NE(remark(kNan), remark(-0.1));
  for (const double odd : {1.01, -0.1, kNan}) EXPECT_NE(remark(odd), "");
}

}  // namespace
}  // namespace palpate::test
