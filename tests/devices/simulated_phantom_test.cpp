#include "devices/simulated/simulated_phantom.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include <gmock/gmock.h>

#include "common/error.h"
#include "common/math/rotation.h"
#include "tests/devices/limiter_support.h"
#include "tests/support/allocation_counter.h"
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
    // Friction greater than the motors' force would hold the handle for ever.
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

PhantomSheet With(const HandleDynamics& dynamics) {
  PhantomSheet sheet = PhantomPremium30();
  sheet.dynamics = dynamics;
  return sheet;
}

SimulatedPhantom Free(const HandleDynamics& dynamics = PhantomPremium30().dynamics,
                      const Pose& X_WH = {}) {
  return SimulatedPhantom(With(dynamics), std::nullopt, X_WH);
}

HandleDynamics Frictionless() {
  HandleDynamics dynamics = PhantomPremium30().dynamics;
  dynamics.coulomb_force_N = dynamics.viscous_N_s_m = 0.0;
  dynamics.coulomb_torque_Nm = dynamics.viscous_Nm_s = 0.0;
  return dynamics;
}

SimulatedHand HandAt(const Pose& where, const HandImpedance& impedance = {}) {
  return {ScriptPlayer(PoseScript({{0.0, where, "hold"}, {1.0, where, "hold"}}), false), impedance};
}

TEST(SimulatedHand, BrakesWhatMovesInIt) {
  const SimulatedHand hand = HandAt({});
  const Wrench brake = hand.WrenchOn({}, {Vec3(0.1, 0, 0), Vec3(0, 0, 2.0)}, 0.5);
  EXPECT_NEAR(brake.force.x(), -0.645, 1e-12);
  EXPECT_NEAR(brake.torque.z(), -0.072, 1e-12);
}

TEST(SimulatedHand, DoesNotBrakeTheMovementThatItWants) {
  const Pose there{Vec3(0.1, 0, 0), Quat::Identity()};
  const ScriptPlayer script(PoseScript({{0.0, Pose{}, ""}, {1.0, there, ""}}), false);
  const SimulatedHand hand(script, HandImpedance{});
  const Wrench none = hand.WrenchOn(script.At(0.4), script.VelocityAt(0.4), 0.4);
  EXPECT_EQ(none.force, Vec3::Zero());
  EXPECT_EQ(none.torque, Vec3::Zero());
}

void Push(SimulatedPhantom& phantom, const Wrench& wrench, int ticks) {
  const LimitedWrench push = PassThrough(wrench);
  for (int i = 0; i < ticks; ++i) phantom.Apply(push);
}

template <class Arm>
concept TakesAnyWrench = requires(Arm& arm, const Wrench& wrench) {
  arm.Apply(wrench);
}
|| requires(Arm& arm, const Wrench& wrench) {
  arm.Pass(wrench);
};
static_assert(!TakesAnyWrench<SimulatedPhantom>, "only what a limiter made, as every device");

TEST(SimulatedPhantom, AcceleratesAsForceLessFrictionOverMass) {
  HandleDynamics dynamics = PhantomPremium30().dynamics;
  dynamics.viscous_N_s_m = 0.0;
  SimulatedPhantom phantom = Free(dynamics);
  const double force = 0.5;
  Push(phantom, {Vec3(force, 0, 0), Vec3::Zero()}, 200);
  const double t = 0.2;
  const double a = (force - dynamics.coulomb_force_N) / dynamics.mass_kg;
  EXPECT_NEAR(phantom.velocity().v.x(), a * t, 1e-9);
  // x = a t^2 / 2; semi-implicit Euler is ahead by a t h / 2.
  const double h = SimulatedPhantom::kSubstep_s;
  EXPECT_NEAR(phantom.pose().p.x(), 0.5 * a * t * t + 0.5 * a * t * h, 1e-9);
}

TEST(SimulatedPhantom, ReachesTheTerminalVelocityOfItsViscousFriction) {
  HandleDynamics dynamics = Frictionless();
  dynamics.viscous_N_s_m = 5.0;
  SimulatedPhantom phantom = Free(dynamics);
  Push(phantom, {Vec3(1.0, 0, 0), Vec3::Zero()}, 1000);
  EXPECT_NEAR(phantom.velocity().v.x(), 1.0 / 5.0, 1e-9);
}

TEST(SimulatedPhantom, SticksWhileTheForceIsBelowDryFriction) {
  SimulatedPhantom phantom = Free();
  Push(phantom, {Vec3(0.19, 0, 0), Vec3(0.0039, 0, 0)}, 1000);
  EXPECT_EQ(phantom.pose().p, Vec3::Zero());
  EXPECT_EQ(phantom.pose().q.vec(), Vec3::Zero());
}

TEST(SimulatedPhantom, TurnsAsTorqueOverInertia) {
  SimulatedPhantom phantom = Free(Frictionless());
  const double torque = 0.01;
  Push(phantom, {Vec3::Zero(), Vec3(0, torque, 0)}, 100);
  const double a = torque / PhantomPremium30().dynamics.inertia_kg_m2;
  EXPECT_NEAR(phantom.velocity().w.y(), a * 0.1, 1e-9);
  const double h = SimulatedPhantom::kSubstep_s;
  EXPECT_NEAR(RotationLog(phantom.pose().q).y(), 0.5 * a * 0.01 + 0.5 * a * 0.1 * h, 1e-9);
}

TEST(SimulatedPhantom, RestsWhereTheHandsSpringBalancesTheForce) {
  HandleDynamics dynamics = Frictionless();
  const HandImpedance impedance;
  SimulatedPhantom phantom(With(dynamics), HandAt({}), {});
  Push(phantom, {Vec3(0, 0, 2.0), Vec3(0.1, 0, 0)}, 4000);
  EXPECT_NEAR(phantom.pose().p.z(), 2.0 / impedance.stiffness_N_m, 1e-7);
  EXPECT_NEAR(RotationLog(phantom.pose().q).x(), 0.1 / impedance.stiffness_Nm_rad, 1e-7);
}

TEST(SimulatedPhantom, DryFrictionLeavesItWithinItsBandOfTheBalance) {
  const HandImpedance impedance;
  const HandleDynamics dynamics = PhantomPremium30().dynamics;
  SimulatedPhantom phantom(With(dynamics), HandAt({}), {});
  Push(phantom, {Vec3(0, 0, 2.0), Vec3::Zero()}, 4000);
  EXPECT_EQ(phantom.velocity().v, Vec3::Zero());
  EXPECT_LE(std::abs(impedance.stiffness_N_m * phantom.pose().p.z() - 2.0),
            dynamics.coulomb_force_N + 1e-9);
}

TEST(SimulatedPhantom, SwingsAtTheFrequencyOfHandAndHandleTogether) {
  HandImpedance impedance;
  impedance.damping_N_s_m = 0.0;
  const HandleDynamics dynamics = Frictionless();
  const Pose off{Vec3(0.01, 0, 0), Quat::Identity()};
  SimulatedPhantom phantom(With(dynamics), HandAt({}, impedance), off);
  const LimitedWrench nothing = PassThrough({});
  int crossings = 0;
  double first = 0.0, last = 0.0, before = off.p.x();
  for (int i = 0; i < 5000; ++i) {
    phantom.Apply(nothing);
    const double x = phantom.pose().p.x();
    if ((x > 0) != (before > 0)) {
      const double when = phantom.time() - 1e-3 * x / (x - before);
      if (crossings++ == 0) first = when;
      last = when;
    }
    before = x;
  }
  const double period = 2.0 * (last - first) / (crossings - 1);
  const double mass = dynamics.mass_kg + impedance.mass_kg;
  EXPECT_NEAR(period, 2.0 * M_PI * std::sqrt(mass / impedance.stiffness_N_m), 1e-5);
}

TEST(SimulatedPhantom, LosesEnergyWhenNothingDrivesIt) {
  SimulatedPhantom phantom = Free();
  Push(phantom, {Vec3(5, -3, 1), Vec3(0.1, 0.05, -0.1)}, 50);
  const LimitedWrench nothing = PassThrough({});
  double energy = phantom.kinetic_energy_J();
  ASSERT_GT(energy, 0.0);
  for (int i = 0; i < 5000; ++i) {
    phantom.Apply(nothing);
    ASSERT_LE(phantom.kinetic_energy_J(), energy);
    energy = phantom.kinetic_energy_J();
  }
  EXPECT_EQ(energy, 0.0);
}

TEST(SimulatedPhantom, ComesToRestInAHandThatHoldsStill) {
  const Pose off{Vec3(0.02, -0.01, 0.03), RotationExp(Vec3(0.3, 0.2, -0.4))};
  SimulatedPhantom phantom(PhantomPremium30(), HandAt({}), off);
  const LimitedWrench nothing = PassThrough({});
  const HandImpedance k;
  const auto energy = [&] {
    return phantom.kinetic_energy_J() + 0.5 * k.stiffness_N_m * phantom.pose().p.squaredNorm() +
           0.5 * k.stiffness_Nm_rad * RotationLog(phantom.pose().q).squaredNorm();
  };
  double last = energy();
  for (int i = 0; i < 5000; ++i) {
    phantom.Apply(nothing);
    ASSERT_LE(energy(), last * (1 + 1e-6)) << i;  // the ripple of Euler's method
    last = energy();
  }
  EXPECT_EQ(phantom.kinetic_energy_J(), 0.0);
}

TEST(SimulatedPhantom, ReadsOnlyWhatItsEncodersResolve) {
  const DeviceInfo info = PhantomPremium30().info;
  const Pose at{Vec3(0.0123456789, -0.0987654321, 0.05), RotationExp(Vec3(0.7, -1.1, 2.0))};
  SimulatedPhantom phantom = Free(PhantomPremium30().dynamics, at);
  const Pose read = phantom.Read().X_WH;
  for (int i = 0; i < 3; ++i) {
    const double counts = read.p[i] / info.position_resolution_m;
    EXPECT_NEAR(counts, std::round(counts), 1e-6);
    EXPECT_LE(std::abs(read.p[i] - at.p[i]), 0.5 * info.position_resolution_m + 1e-12);
  }
  EXPECT_NE(read.p, at.p);
  const double turned = RotationLog(read.q * at.q.conjugate()).norm();
  EXPECT_GT(turned, 0.0);
  EXPECT_LE(turned, 2.0 * info.rotation_resolution_rad);
  EXPECT_NEAR(read.q.norm(), 1.0, 1e-15);
}

TEST(SimulatedPhantom, EstimatesItsVelocityFromTheEncoders) {
  SimulatedPhantom phantom = Free(Frictionless());
  Push(phantom, {Vec3(1.0, 0, 0), Vec3::Zero()}, 20);
  Push(phantom, {}, 50);
  const double truth = phantom.velocity().v.x();
  // One count in a millisecond is 20 mm/s; the filter leaves less than that.
  EXPECT_NEAR(phantom.Read().V_WH.v.x(), truth, 0.02);
}

TEST(SimulatedPhantom, StopsAtTheEndOfItsWorkspace) {
  SimulatedPhantom phantom = Free();
  Push(phantom, {Vec3(0, 0, 20), Vec3::Zero()}, 1000);
  EXPECT_EQ(phantom.pose().p.z(), 0.5 * phantom.info().workspace_m.z());
  EXPECT_EQ(phantom.velocity().v.z(), 0.0);
}

TEST(SimulatedPhantom, RollsWithLessTorqueThanItYaws) {
  const double inertia = PhantomPremium30().dynamics.inertia_kg_m2;
  SimulatedPhantom rolled = Free(Frictionless());
  rolled.Apply(PassThrough({Vec3::Zero(), Vec3(0, 0, 5)}));
  EXPECT_NEAR(rolled.velocity().w.z(), 0.170 * 1e-3 / inertia, 1e-9);
  SimulatedPhantom yawed = Free(Frictionless());
  yawed.Apply(PassThrough({Vec3::Zero(), Vec3(0.5, 0, 0)}));
  EXPECT_NEAR(yawed.velocity().w.x(), 0.5 * 1e-3 / inertia, 1e-2);
}

/// Closed as a station does: the force is from the pose of a millisecond ago, through the limiter.
TEST(SimulatedPhantom, RestsAgainstAWallWithoutALimitCycle) {
  const double wall = 1000.0, torsion = 1.0;  // the coupling of the chapter's experiments
  const HandImpedance impedance;
  // 20 mm inside the wall, turned by 0.3 rad.
  const Pose wanted{Vec3(0, 0, -0.020), RotationExp(Vec3(0.3, 0, 0))};
  SimulatedPhantom phantom(PhantomPremium30(), HandAt(wanted), {});
  WrenchLimiter limiter(WrenchLimits::Of(phantom.info()));
  limiter.Enable(true);
  // Forces ramp in before the hand arrives: a hand that was inside already is not pushed out.
  for (int i = 0; i < 300; ++i) limiter.Limit({{}, {}, {}, {}, 1e-3, 1e-3, 1e-3});
  Wrench reply;
  double fastest = 0.0;
  for (int i = 0; i < 6000; ++i) {
    const DeviceSample sample = phantom.Read();
    const Pose& read = sample.X_WH;
    phantom.Apply(limiter.Limit({reply, {}, read, sample.V_WH, 1e-3, 1e-3, 1e-3}));
    reply.force = Vec3(0, 0, read.p.z() < 0.0 ? -wall * read.p.z() : 0.0);
    reply.torque = -torsion * RotationLog(read.q);
    if (i >= 5000) fastest = std::max(fastest, phantom.velocity().v.norm());
  }
  EXPECT_EQ(fastest, 0.0);  // held by dry friction: at rest to the last bit
  EXPECT_EQ(phantom.velocity().w, Vec3::Zero());
  // Two springs in series, within the band of dry friction.
  const double force = 0.020 * impedance.stiffness_N_m * wall / (impedance.stiffness_N_m + wall);
  EXPECT_NEAR(reply.force.z(), force, PhantomPremium30().dynamics.coulomb_force_N);
  const double torque =
      0.3 * impedance.stiffness_Nm_rad * torsion / (impedance.stiffness_Nm_rad + torsion);
  EXPECT_NEAR(-reply.torque.x(), torque, 2.0 * PhantomPremium30().dynamics.coulomb_torque_Nm);
}

TEST(SimulatedPhantom, AllocatesNothingInTheLoop) {
  SimulatedPhantom phantom(PhantomPremium30(), HandAt({}), {});
  const LimitedWrench push = PassThrough({Vec3(0.3, -0.2, 0.1), Vec3(0.01, 0, 0)});
  const std::uint64_t before = test::AllocationsOfThisThread();
  for (int i = 0; i < 100; ++i) {
    phantom.Read();
    phantom.Apply(push);
    phantom.activity();
  }
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
}

TEST(SimulatedPhantom, MovesAlikeAtWhateverRateItIsServed) {
  const auto pushed_for = [](double rate_Hz, int ticks) {
    PhantomSheet sheet = PhantomPremium30();
    sheet.info.rate_Hz = rate_Hz;
    SimulatedPhantom phantom(sheet, HandAt({}), {});
    const LimitedWrench push = PassThrough({Vec3(1.0, 0, 0), Vec3(0.01, 0, 0)});
    for (int i = 0; i < ticks; ++i) phantom.Apply(push);
    EXPECT_NEAR(phantom.time(), 0.2, 1e-12);
    return phantom.pose();
  };
  const Pose at_1k = pushed_for(1000.0, 200);
  EXPECT_GT(at_1k.p.x(), 1e-3);
  for (const double rate : {2000.0, 4000.0}) {
    const Pose pose = pushed_for(rate, static_cast<int>(0.2 * rate));
    EXPECT_LT((pose.p - at_1k.p).norm(), 1e-12);  // the same sub-steps
    EXPECT_LT(RotationLog(pose.q * at_1k.q.conjugate()).norm(), 1e-12);
  }
  const Pose pose = pushed_for(1500.0, 300);  // sub-steps of 111 us
  EXPECT_LT((pose.p - at_1k.p).norm(), 1e-5);
}

TEST(SimulatedPhantom, RefusesARateThatItCannotKeep) {
  PhantomSheet sheet = PhantomPremium30();
  for (const double rate : {0.0, 99.0, 4001.0, -1000.0, std::nan("")}) {
    sheet.info.rate_Hz = rate;
    EXPECT_THROW(SimulatedPhantom(sheet, std::nullopt, {}), Error) << rate;
  }
}

TEST(SimulatedPhantom, RepeatsToTheBit) {
  const Pose there{Vec3(0.05, 0.02, -0.03), RotationExp(Vec3(0.5, -0.2, 0.9))};
  const auto run = [&] {
    SimulatedHand hand(ScriptPlayer(PoseScript({{0.0, Pose{}, "go"}, {1.0, there, "stay"}}), true),
                       HandImpedance{});
    SimulatedPhantom phantom(PhantomPremium30(), hand, {});
    const LimitedWrench push = PassThrough({Vec3(0.3, -0.2, 0.1), Vec3(0.01, 0, 0)});
    for (int i = 0; i < 3000; ++i) phantom.Apply(push);
    return phantom.pose();
  };
  const Pose a = run(), b = run();
  EXPECT_EQ(a.p, b.p);
  EXPECT_EQ(a.q.coeffs(), b.q.coeffs());
}

}  // namespace
}  // namespace palpate
