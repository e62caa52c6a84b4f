#include "devices/limiter/energy_stage.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "devices/limiter/limiter_chain.h"
#include "devices/simulated/phantom_sheets.h"
#include "tests/devices/limiter/limiter_figures.h"
#include "tests/support/optimised.h"
#include "tests/support/port_loop.h"
#include "tests/support/random.h"
#include "tests/support/uncontrolled_limiter.h"

namespace palpate {
namespace {

using test::kTick;
using test::PhantomLimits;
using test::PortLoopCase;
using test::PortLoopFigures;
using test::RunPortLoop;

/// An energy stage with a handle on one axis, to which all its force is applied.
class Axis {
 public:
  explicit Axis(double stiffness = 0.0) : stage(PhantomLimits()) {
    if (stiffness > 0.0) stage.SetStiffness(stiffness);
  }
  /// Moves the handle by `step`, then asks for the force `wanted`.
  double Step(double step, double wanted, double gain = 1.0, double dt_s = kTick) {
    z_ += step;
    const Wrench out = stage.Pass({Vec3(0, 0, wanted), Vec3::Zero()}, gain,
                                  {Vec3(0, 0, z_), Quat::Identity()}, dt_s);
    stage.Hold({gain * out.force, gain * out.torque});
    given = gain * out.force.z();
    return out.force.z();
  }
  double z() const { return z_; }
  /// Energy given to the hand so far [J].
  double Generated() const { return -stage.observer().energy_J(); }

  EnergyStage stage;
  double given = 0.0;

 private:
  double z_ = 0.0;
};

/// A workspace's scale changes nothing for the hand: at scale s the account in the scene equals
/// that of the hand, bit for bit where s is a power of two.
TEST(EnergyStage, KeepsTheAccountOfTheHandWhateverTheWorkspacesScale) {
  for (const double s : {0.25, 0.5}) {
    DeviceInfo hand = PhantomPremium30().info;
    hand.max_torque_Nm = hand.continuous_torque_Nm = 0.008;  // less than a guide may ask for
    DeviceInfo scene = hand;
    scene.motion_scale = s;
    scene.position_resolution_m *= s;
    scene.max_torque_Nm *= s;
    scene.continuous_torque_Nm *= s;
    EnergyStage of_hand(WrenchLimits::Of(hand)), of_scene(WrenchLimits::Of(scene));
    of_hand.SetStiffness(1000.0);
    of_scene.SetStiffness(1000.0 / s);
    test::Random random(31);
    Pose X;
    Vec3 v = Vec3::Zero(), w = Vec3::Zero();
    for (int i = 0; i < 20'000; ++i) {
      v += 5e-3 * random.InCube(1.0) - 0.01 * v;
      w += 5e-2 * random.InCube(1.0) - 0.01 * w;
      X.p += kTick * v;
      X.q = (RotationExp(kTick * w) * X.q).normalized();
      const Wrench asked{-2.0 * Vec3(X.p / 0.01), 1e-3 * random.InCube(1.0)};
      const Wrench felt = of_hand.Pass(asked, 1.0, X, kTick);
      const Wrench in_scene =
          of_scene.Pass({asked.force, s * asked.torque}, 1.0, {s * X.p, X.q}, kTick);
      ASSERT_EQ(in_scene.force, felt.force) << i;
      ASSERT_EQ(in_scene.torque, s * felt.torque) << i;
      of_hand.Hold(felt);
      of_scene.Hold(in_scene);
    }
    EXPECT_EQ(of_scene.observer().energy_J(), of_hand.observer().energy_J());
    EXPECT_GT(of_hand.count(), 100u) << "it has held something back";
  }
}

TEST(EnergyStage, LeavesAHandleAloneThatHasNotMoved) {
  Axis axis(1000.0);
  double force = 0.0;
  for (int i = 0; i < 100; ++i) force = axis.Step(0.0, 5.0);
  EXPECT_EQ(force, 5.0);
  EXPECT_EQ(axis.stage.count(), 0u);
}

TEST(EnergyStage, LeavesASpringAloneThatIsPressedAndLetGoSlowly) {
  Axis axis(1000.0);
  double most = 0.0;
  const auto feel = [&](double step) {
    const double wanted = std::max(0.0, -1000.0 * (axis.z() + step));
    most = std::max(most, std::abs(axis.Step(step, wanted) - wanted));
  };
  for (int i = 0; i < 300; ++i) feel(-1e-5);  // 10 mm/s, 3 mm deep: 3 N
  for (int i = 0; i < 300; ++i) feel(0.0);
  for (int i = 0; i < 310; ++i) feel(1e-5);
  EXPECT_LE(most, 0.05);
  EXPECT_LE(axis.Generated(), 0.0);
}

TEST(EnergyStage, LeavesALightTouchAtRestMostOfItsForce) {
  Axis axis(2000.0);
  const auto feel = [&](double step) { return axis.Step(step, -2000.0 * (axis.z() + step)); };
  double force = 0.0;
  for (int i = 0; i < 80; ++i) force = feel(i % 10 ? 0.0 : -20e-6);  // 2 mm/s, 0.16 mm deep
  for (int i = 0; i < 500; ++i) force = feel(0.0);
  EXPECT_GE(force, 0.8 * 0.32);
}

/// Late ticks take nothing from a hand that rests on a spring.
TEST(EnergyStage, LeavesATouchAtRestItsForceWhereTicksAreLate) {
  test::Random random(5);
  for (const double late : {0.0, 0.1}) {
    Axis axis(1000.0);
    double least = 1e9;
    for (int i = 0; i < 20'000; ++i) {
      const bool rests = i > 400;
      const double step = rests || i % 10 ? 0.0 : -20e-6;  // 2 mm/s, 0.8 mm deep
      const double tick = random.Uniform(0.0, 1.0) < late ? random.Uniform(1e-3, 5e-3) : kTick;
      const double force = axis.Step(step, -1000.0 * (axis.z() + step), 1.0, tick);
      if (rests) least = std::min(least, force);
    }
    EXPECT_GE(least, 0.8) << late;
  }
}

TEST(EnergyStage, GivesNothingToAHandThatPutNothingIn) {
  // The plainest active device: a force along the motion from the first tick on.
  Axis axis;
  for (int i = 0; i < 1000; ++i) axis.Step(2e-5, 5.0);
  // The force of the first tick is lent: the handle had not moved yet.
  EXPECT_LE(axis.Generated(),
            PhantomLimits().rates().contact_force * kTick * 2e-5 + EnergyStage::kSeed_J);
  EXPECT_GT(axis.stage.count(), 900u);
}

TEST(EnergyStage, TakesTheSeedBackOnceTheHandHasPutInMore) {
  Axis axis;
  for (int i = 0; i < 10; ++i) axis.Step(-1e-4, 1.0);
  for (int i = 0; i < 1000; ++i) axis.Step(1e-4, 5.0);
  EXPECT_LE(axis.Generated(), 0.0);
}

TEST(EnergyStage, AccountsWhatIsAppliedAndNotWhatItWished) {
  // Pressed during the ramp, then let go: accounting the whole force would give 5 N over 5 mm.
  Axis axis;
  axis.Step(-1e-4, 5.0, 0.0);
  for (int i = 0; i <= 200; ++i) axis.Step(i % 2 ? 1e-5 : -1e-5, 5.0, i / 200.0);
  for (int i = 0; i < 500; ++i) axis.Step(1e-5, 5.0);
  EXPECT_LE(axis.Generated(), 1.1 * EnergyStage::kSeed_J);
}

TEST(EnergyStage, LetsAHandThatWasInsideFeelTheObjectAsItGoesFurtherInHoweverSlowly) {
  Axis axis(1000.0);
  for (int i = 0; i < 100; ++i) axis.Step(i == 50 ? 20e-6 : 0.0, 2.0);  // starts inside, in debt
  ASSERT_LT(axis.given, 0.1);
  // The loan is 2 N over one encoder step.  At 5 mm/s, one step in four ticks, it is paid back and
  // the force whole within 2 mm.
  for (int i = 0; i < 4 * 100; ++i) axis.Step(i % 4 ? 0.0 : -20e-6, 2.0);
  EXPECT_EQ(axis.given, 2.0);
}

TEST(EnergyStage, GrantsARampWhatTheCouplingHoldsAndNoMoreHoweverLongItPushes) {
  constexpr double kForce_N = 5.0, kStiffness = 1000.0;
  for (const bool spring : {true, false}) {
    EnergyStage stage(PhantomLimits());
    stage.SetStiffness(kStiffness);
    double z = 0.0, given_J = 0.0, held_N = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const double way = i < 10 ? 0.0 : 1e-5;  // out, and never in
      z += way;
      given_J += held_N * way;
      const double gain = std::min(1.0, (i + 1) / 200.0);
      // A wall that lets go, and one that pushes for ever.
      const double wanted = spring ? std::max(0.0, kForce_N - kStiffness * z) : kForce_N;
      const Wrench out = stage.Pass({Vec3(0, 0, wanted), Vec3::Zero()}, gain,
                                    {Vec3(0, 0, z), Quat::Identity()}, kTick, i > 0, gain < 1.0);
      stage.Hold({gain * out.force, Vec3::Zero()});
      held_N = gain * out.force.z();
    }
    EXPECT_LE(given_J, 0.5 * kForce_N * kForce_N / kStiffness + 2.0 * EnergyStage::kSeed_J);
    EXPECT_LE(given_J, stage.lent_J() + 2.0 * EnergyStage::kSeed_J);
    EXPECT_GT(given_J, spring ? 1e-3 : 5e-3) << "it is felt";
  }
}

/// A server that lies to get energy into a hand; the hand comes back whenever nothing pushes it.
class LyingServer : public testing::Test {
 protected:
  static constexpr double kPush_N = 5.0;
  static constexpr double kStroke_m = 5e-3;

  void SetUp() override {
    limiter = LimiterChain<EnergyStage>(PhantomLimits());
    limiter.energy().SetStiffness(1000.0);
    limiter.Enable(true);
    z = held_N = silence_s = given_J = most_given_J = 0.0;
  }
  /// Runs `ticks` in which the hand moves at `v` and the server wants the force `wanted`.
  void Run(int ticks, double v, double wanted, bool entering = false, bool answers = true) {
    for (int i = 0; i < ticks; ++i) {
      z += v * kTick;
      given_J += held_N * v * kTick;
      most_given_J = std::max(most_given_J, given_J);
      silence_s = answers ? 0.0 : silence_s + kTick;
      LimiterInput in;
      in.wanted.force.z() = wanted;
      in.X_WH.p.z() = z;
      in.silence_s = in.age_s = silence_s;
      in.dt_s = kTick;
      in.entering = entering;
      held_N = limiter.Limit(in).force.z();
    }
  }
  void MoveOut(double wanted, bool entering = false) {
    Run(100, kStroke_m / 0.1, wanted, entering);
  }

  LimiterChain<EnergyStage> limiter{PhantomLimits()};
  double z = 0.0, held_N = 0.0, silence_s = 0.0;
  double given_J = 0.0, most_given_J = 0.0;
};

/// It begins again and again, falls silent in between, or waits until the hand rests.
TEST_F(LyingServer, GetsNoMoreThanOneBudgetIntoAHand) {
  enum Way { kBeginsAgain, kFallsSilent, kWaits };
  for (const Way way : {kBeginsAgain, kFallsSilent, kWaits}) {
    SCOPED_TRACE(way);
    SetUp();
    // When it waits, its force is never quite zero, so the contact never ends.
    const double between_N = way == kWaits ? 1e-6 : way == kFallsSilent ? kPush_N : 0.0;
    Run(300, 0.0, way == kWaits ? 1e-6 : 0.0);
    for (int i = 0; i < 50; ++i) {
      const bool entering = way == kBeginsAgain;
      Run(entering ? 60 : 250, 0.0, kPush_N, entering || (way == kWaits && i == 0));
      MoveOut(kPush_N, entering);
      Run(100, -kStroke_m / 0.1, between_N, false, way != kFallsSilent);
    }
    EXPECT_LE(most_given_J, EnergyStage::kBudget_J + 2.0 * EnergyStage::kSeed_J);
    EXPECT_GT(most_given_J, 0.8 * EnergyStage::kBudget_J) << "it tries, at least";
  }
}

TEST_F(LyingServer, IsNotTakenForOneThatIsStartedAgainUnderAHandThatRests) {
  for (int i = 0; i < 50; ++i) {
    Run(100, 0.0, kPush_N, false, false);
    Run(500, 0.0, kPush_N);
    // Unused budget came back: at the end the hand is still pushed out with the whole force.
    ASSERT_EQ(held_N, kPush_N) << i;
    ASSERT_LE(limiter.energy().lent_J(), 0.5 * kPush_N * kPush_N / 1000.0 + 1e-9);
  }
}

TEST_F(LyingServer, HasTheBudgetAgainOnceTheHandHasPutItIn) {
  Run(300, 0.0, 0.0);
  for (int i = 0; i < 50; ++i) {
    Run(60, 0.0, kPush_N, true);
    MoveOut(kPush_N, true);
    Run(100, -kStroke_m / 0.1, 0.0);
  }
  Run(1000, -0.05, 2.0);  // 0.1 J of drag
  EXPECT_LT(limiter.energy().lent_J(), 1e-3);
  Run(200, 0.0, 0.0);
  given_J = most_given_J = 0.0;
  Run(20, 0.0, kPush_N, true);
  MoveOut(kPush_N, true);
  EXPECT_GT(given_J, 5e-3);
}

TEST(EnergyStage, ForgetsTheHeatOfFrictionSoThatNoActivePhaseHidesBehindIt) {
  Axis axis(1000.0);
  for (int i = 0; i < 10'000; ++i) axis.Step(-1e-4, 2.0);  // 2 J of drag
  EXPECT_GT(axis.stage.observer().energy_J(), 1.9);
  const double before = axis.Generated();
  for (int i = 0; i < 10'000; ++i) axis.Step(1e-4, 2.0);  // the same back, if allowed
  // What a contact can store, and what came in while the rest was being forgotten.
  const double held = 0.5 * 2.0 * EnergyStage::kDeepest_m;
  EXPECT_LE(axis.Generated() - before, held + 2.0 * 0.1 * EnergyStage::kForget_s);
}

TEST(EnergyStage, ForgetsAContactInFreeSpace) {
  Axis axis(1000.0);
  for (int i = 0; i < 100; ++i) axis.Step(-1e-4, 2.0);
  for (int i = 0; i < 500; ++i) axis.Step(1e-5, 0.0);
  EXPECT_NEAR(axis.stage.store_J(), 0.0, 1e-6);
}

TEST(EnergyStage, DoesNotChatterUnderEncoderNoiseAtRest) {
  constexpr double kStep = 20e-6;
  test::Random random(2);
  Axis axis(1000.0);
  double at = 0.0, most = 0.0;
  for (int i = 0; i < 150; ++i) axis.Step(-kStep, -1000.0 * (axis.z() - kStep));
  for (int i = 0; i < 5000; ++i) {
    const double next = random.Below(2) ? kStep : 0.0;
    const double wanted = -1000.0 * (axis.z() + next - at);
    most = std::max(most, std::abs(axis.Step(next - at, wanted) - wanted));
    at = next;
  }
  // At 3 N, moving 20 mm/s back and forth each tick, one encoder step of 20 mN is left.
  EXPECT_LE(most, 0.1);
}

TEST(EnergyStage, RendersNothingWhereItCannotSeeTheHandle) {
  EnergyStage stage(PhantomLimits());
  Wrench out;
  for (int i = 0; i < 10; ++i) {
    out = stage.Pass({Vec3(0, 0, 5), Vec3::Zero()}, 1.0,
                     {Vec3(0, std::nan(""), 0), Quat::Identity()}, kTick);
  }
  EXPECT_EQ(out.force, Vec3::Zero());
}

TEST(EnergyStage, MovesNoFasterThanItsShareOfTheSlewLimit) {
  const double rate = PhantomLimits().rates().contact_force;
  test::Random random(4);
  Axis axis(1000.0);
  double last = 0.0;
  for (int i = 0; i < 100'000; ++i) {
    const double now = axis.Step(1e-4 * random.Uniform(-1.0, 1.0), random.Uniform(-22.0, 22.0));
    ASSERT_LE(std::abs(now - last), rate * kTick * (1 + 1e-12));
    ASSERT_LE(std::abs(now), 22.0);
    last = now;
  }
}

/// Whatever the delay, the hand is given no energy.
class EnergyAtThePort : public testing::TestWithParam<int> {};

TEST_P(EnergyAtThePort, IsNeverGivenInAClosedLoopWithDelayAndLoss) {
  const unsigned seeds = test::kOptimised ? 3 : 1;
  for (const double stiffness : {300.0, 1000.0, 2000.0}) {
    for (const double known : {0.0, stiffness}) {  // what the limiter is told of it
      for (unsigned seed = 1; seed <= seeds; ++seed) {
        PortLoopCase c;
        c.delay_ms = GetParam();
        c.loss = 0.1;
        c.stiffness_N_per_m = stiffness;
        c.seed = seed;
        c.rate_Hz = seed;
        test::UncontrolledLimiter without(PhantomLimits());
        const PortLoopFigures active = RunPortLoop(without, c);
        EXPECT_GT(active.generated_J, 0.5e-3) << "the case shows nothing";
        WrenchLimiter limiter(PhantomLimits());
        limiter.SetStiffness(known);
        const PortLoopFigures figures = RunPortLoop(limiter, c);
        SCOPED_TRACE(testing::Message()
                     << stiffness << " N/m, told " << known << ", seed " << seed);
        EXPECT_LE(figures.generated_J, 0.0);
        EXPECT_LE(figures.most_generated_J, 2.0 * EnergyStage::kSeed_J);
        EXPECT_GT(figures.absorbed_J, 5e-3) << "a wall that is not felt is no wall";
        EXPECT_NEAR(limiter.observer().energy_J(), -figures.generated_J, 0.1e-3);
      }
    }
  }
}

/// The force held while a tick is late does work that the stage could not foresee; the stage takes
/// it back afterwards.
TEST_P(EnergyAtThePort, IsTakenBackWhereTicksAreLate) {
  for (const double stiffness : {300.0, 1000.0, 2000.0}) {
    for (unsigned seed = 1; seed <= 3; ++seed) {
      PortLoopCase c;
      c.delay_ms = GetParam();
      c.late = 0.1;
      c.stiffness_N_per_m = stiffness;
      c.seed = seed;
      c.rate_Hz = seed;
      SCOPED_TRACE(testing::Message() << stiffness << " N/m, seed " << seed);
      test::UncontrolledLimiter without(PhantomLimits());
      const PortLoopFigures active = RunPortLoop(without, c);
      WrenchLimiter limiter(PhantomLimits());
      limiter.SetStiffness(stiffness);
      const PortLoopFigures figures = RunPortLoop(limiter, c);
      // One late tick at the greatest force and speed of the run.
      const double one_J =
          stiffness * figures.deepest_m * figures.fastest_m_s * test::kMostLateTick_s;
      EXPECT_LE(figures.generated_J, 0.0);
      EXPECT_LE(figures.most_generated_J, one_J);
      EXPECT_LE(figures.most_generated_J, 0.1 * active.most_generated_J);
      EXPECT_GT(figures.absorbed_J, 5e-3) << "a wall that is not felt is no wall";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Delays, EnergyAtThePort, testing::Values(0, 1, 5, 10, 20));

TEST(EnergyAtThePort, LeavesAPassiveWallPracticallyUntouched) {
  PortLoopCase c;  // b = 6.55 N s/m against k T / 2 = 0.25: well inside
  c.stiffness_N_per_m = 500.0;
  WrenchLimiter limiter(PhantomLimits());
  limiter.SetStiffness(500.0);
  const PortLoopFigures figures = RunPortLoop(limiter, c);
  EXPECT_GT(figures.rms_wanted_N, 1.0);
  EXPECT_LE(figures.rms_change_N, 0.02 * figures.rms_wanted_N);
  EXPECT_LE(figures.most_change_N, 0.1);
}

}  // namespace
}  // namespace palpate
