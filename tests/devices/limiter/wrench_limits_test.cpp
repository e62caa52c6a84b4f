#include "devices/limiter/wrench_limits.h"

#include <limits>

#include <gtest/gtest.h>

#include "common/error.h"
#include "devices/simulated/phantom_sheets.h"

namespace palpate {
namespace {

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

TEST(WrenchLimits, AreTightenedByAForceAndNeverLoosened) {
  const DeviceInfo info = PhantomPremium30().info;
  const WrenchLimits limits = WrenchLimits::Of(info, 2.2);
  EXPECT_DOUBLE_EQ(limits.force_N(), 2.2);
  EXPECT_DOUBLE_EQ(limits.continuous_force_N(), 2.2);
  EXPECT_DOUBLE_EQ(limits.torque_Nm(), 0.0515);
  EXPECT_DOUBLE_EQ(limits.continuous_torque_Nm(), 0.0515);
  EXPECT_EQ(limits.force_slew_N_per_ms(), 4.4) << "a touch is softened no more than before";
  EXPECT_EQ(WrenchLimits::Of(info, 0.5).bounds().led_force_N, 0.5);
  EXPECT_EQ(WrenchLimits::Of(info, 50.0).force_N(), 22.0);
  EXPECT_EQ(WrenchLimits::Of(info, 50.0).torque_Nm(), 0.515);
  for (const double none : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(WrenchLimits::Of(info, none), Error);
  }
}

}  // namespace
}  // namespace palpate
