#include "devices/limiter/wrench_limits.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "devices/simulated/phantom_sheets.h"
#include "tests/support/complaint.h"

namespace palpate {
namespace {

using testing::HasSubstr;

TEST(WrenchLimits, AreTheDataSheets) {
  const WrenchLimits limits = WrenchLimits::Of(PhantomPremium30().info);
  EXPECT_EQ(limits.force_N(), 22.0);
  EXPECT_EQ(limits.continuous_force_N(), 3.0);
  EXPECT_EQ(limits.torque_Nm(), 0.515);
  EXPECT_EQ(limits.continuous_torque_Nm(), 0.188);
  EXPECT_EQ(limits.force_slew_N_per_ms(), 4.4);
}

TEST(WrenchLimits, RefuseADataSheetThatSaysNothingOrNonsense) {
  const auto refused = [](auto change) {
    DeviceInfo info = PhantomPremium30().info;
    change(info);
    EXPECT_THROW(WrenchLimits::Of(info), Error);
  };
  refused([](DeviceInfo& info) { info = DeviceInfo{}; });
  for (const double nonsense : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                                std::numeric_limits<double>::infinity()}) {
    refused([&](DeviceInfo& info) { info.max_force_N = nonsense; });
    refused([&](DeviceInfo& info) { info.max_torque_Nm = nonsense; });
    refused([&](DeviceInfo& info) { info.continuous_force_N = nonsense; });
    refused([&](DeviceInfo& info) { info.continuous_torque_Nm = nonsense; });
    refused([&](DeviceInfo& info) { info.thermal_time_s = nonsense; });
  }
  refused([](DeviceInfo& info) { info.continuous_force_N = 23.0; });  // above the peak
  refused([](DeviceInfo& info) { info.thermal_time_s = 0.06; });
}

TEST(WrenchLimits, AreOnlyTightened) {
  const WrenchLimits limits = WrenchLimits::Of(PhantomPremium30().info);
  WrenchLimits::Bounds half = limits.bounds();
  half.force_N *= 0.5;
  half.continuous_torque_Nm *= 0.5;
  EXPECT_EQ(limits.TightenedTo(half).force_N(), 11.0);
  const auto refused = [&](double WrenchLimits::Bounds::*bound, const char* name) {
    WrenchLimits::Bounds looser = limits.bounds();
    looser.*bound *= 1.01;
    EXPECT_THAT(test::ComplaintOf([&] { limits.TightenedTo(looser); }), HasSubstr(name));
    WrenchLimits::Bounds none = limits.bounds();
    none.*bound = 0.0;
    EXPECT_THROW(limits.TightenedTo(none), Error);
  };
  using Bounds = WrenchLimits::Bounds;
  refused(&Bounds::force_N, "force_N");
  refused(&Bounds::torque_Nm, "torque_Nm");
  refused(&Bounds::continuous_force_N, "continuous_force_N");
  refused(&Bounds::continuous_torque_Nm, "continuous_torque_Nm");
  refused(&Bounds::force_slew_N_per_ms, "force_slew_N_per_ms");
  refused(&Bounds::torque_slew_Nm_per_ms, "torque_slew_Nm_per_ms");
  refused(&Bounds::led_force_N, "led_force_N");
  refused(&Bounds::led_torque_Nm, "led_torque_Nm");
}

TEST(WrenchLimits, RefuseASlewLimitThatWouldHoldUpTheFade) {
  const WrenchLimits limits = WrenchLimits::Of(PhantomPremium30().info);
  WrenchLimits::Bounds slow = limits.bounds();
  slow.force_slew_N_per_ms = 1.0;
  EXPECT_THROW(limits.TightenedTo(slow), Error);
}

}  // namespace
}  // namespace palpate
