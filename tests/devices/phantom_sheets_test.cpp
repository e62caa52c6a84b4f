#include "devices/simulated/phantom_sheets.h"

#include <cmath>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "devices/simulated/simulated_phantom.h"
#include "tests/devices/limiter_support.h"
#include "tests/support/complaint.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

TEST(PhantomSheets, AreFoundByTheirNamesTheFirstBeingTheChapters) {
  EXPECT_EQ(PhantomSheets().front().name, "premium-3.0");
  for (const PhantomSheet& sheet : PhantomSheets()) {
    EXPECT_EQ(PhantomSheetOf(std::string(sheet.name)).info.model, sheet.info.model);
  }
  EXPECT_THAT(test::ComplaintOf([] { PhantomSheetOf("premium-6.0"); }),
              testing::HasSubstr("premium-3.0, premium-1.5, touch"));
}

TEST(PhantomSheets, LeaveNothingOutThatASimulationNeeds) {
  for (const PhantomSheet& sheet : PhantomSheets()) {
    SCOPED_TRACE(sheet.name);
    const DeviceInfo& info = sheet.info;
    EXPECT_GT(info.continuous_force_N, 0.0);
    EXPECT_GT(info.max_force_N, info.continuous_force_N);
    EXPECT_GT(info.workspace_m.minCoeff(), 100.0 * info.position_resolution_m);
    EXPECT_GT(info.position_resolution_m, 0.0);
    EXPECT_GT(info.rotation_resolution_rad, 0.0);
    EXPECT_GT(info.max_stiffness_N_m, 0.0);
    EXPECT_GT(sheet.dynamics.mass_kg, 0.0);
    EXPECT_GT(sheet.dynamics.inertia_kg_m2, 0.0);
    // Friction that the motors do not overcome would hold the handle for ever.
    EXPECT_LT(sheet.dynamics.coulomb_force_N, info.continuous_force_N);
    if (info.torque_axes > 0) {
      EXPECT_GT(info.max_torque_Nm, info.continuous_torque_Nm);
      EXPECT_LT(sheet.dynamics.coulomb_torque_Nm, sheet.dynamics.max_roll_torque_Nm);
    } else {
      EXPECT_EQ(info.max_torque_Nm, 0.0);
    }
    EXPECT_NO_THROW(WrenchLimiter(WrenchLimits::Of(info)));
  }
}

TEST(PhantomSheets, AreWhatTheReadmeSays) {
  const std::string readme = ReadWholeFile(std::string(PALPATE_SOURCE_DIR) + "/devices/README.md");
  const auto rounded = [](double value) { return std::round(1e6 * value) / 1e6; };
  std::ostringstream reach, force, resolution, mass;
  for (const PhantomSheet& sheet : PhantomSheets()) {
    const DeviceInfo& info = sheet.info;
    const Vec3 mm = 1e3 * info.workspace_m;
    reach << ' ' << rounded(mm.x()) << " × " << rounded(mm.y()) << " × " << rounded(mm.z())
          << " S |";
    force << ' ' << info.max_force_N << ", " << info.continuous_force_N << " S |";
    resolution << ' ' << rounded(1e3 * info.position_resolution_m) << " S |";
    mass << ' ' << rounded(1e3 * sheet.dynamics.mass_kg) << " S |";
  }
  for (const std::string& row :
       {"| workspace, mm |" + reach.str(), "| peak, continuous force, N |" + force.str(),
        "| position resolution, mm |" + resolution.str(), "| apparent mass, g |" + mass.str()}) {
    EXPECT_THAT(readme, testing::HasSubstr(row));
  }
}

TEST(PhantomSheets, MakeArmsThatGiveTheirPeakForceAndNoMore) {
  for (PhantomSheet sheet : PhantomSheets()) {
    SCOPED_TRACE(sheet.name);
    sheet.dynamics.coulomb_force_N = sheet.dynamics.viscous_N_s_m = 0.0;
    SimulatedPhantom arm(sheet, std::nullopt, {});
    arm.Apply(PassThrough({Vec3(500, 0, 0), Vec3::Zero()}));
    EXPECT_NEAR(arm.velocity().v.x(), sheet.info.max_force_N * 1e-3 / sheet.dynamics.mass_kg, 1e-9);
  }
}

TEST(PhantomTouch, LosesTorqueInItsMotorsAndSaysSoBeforeTheLimiter) {
  SimulatedPhantom touch(PhantomTouch(), std::nullopt, {});
  touch.Apply(PassThrough({Vec3::Zero(), Vec3(1.0, 0.5, -0.2)}));
  EXPECT_EQ(touch.velocity().w, Vec3::Zero());
  Wrench contact{Vec3(1, 2, 3), Vec3(0.1, 0.2, 0.3)};
  Wrench led{Vec3(0.1, 0, 0), Vec3(0.01, 0, 0)};
  touch.Shape(contact, led);
  EXPECT_EQ(contact.force, Vec3(1, 2, 3));
  EXPECT_EQ(contact.torque, Vec3::Zero());
  EXPECT_EQ(led.torque, Vec3::Zero());
  EXPECT_THAT(touch.info().model, testing::HasSubstr("no torque"));
  contact.torque = Vec3(0.1, 0.2, 0.3);
  SimulatedPhantom(PhantomPremium15(), std::nullopt, {}).Shape(contact, led);
  EXPECT_EQ(contact.torque, Vec3(0.1, 0.2, 0.3)) << "an arm that renders it";
}

}  // namespace
}  // namespace palpate
