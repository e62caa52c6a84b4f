#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "server/physics/haptic_step.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/random.h"
#include "tests/support/step_bench.h"
#include "tests/support/test_scenes.h"
#include "tests/support/volume_left.h"

namespace palpate {
namespace {

Material Cuttable(double pressure, double viscosity, double friction = 0.0) {
  return {
      .cutting_pressure = pressure, .cutting_viscosity = viscosity, .cutting_friction = friction};
}

using test::At;
using test::Ball;
using test::MakeTree;

/// A block with its top at z = 0, and a bur with axis z at the end of a handle in free space.
class Spin : public testing::Test {
 protected:
  static constexpr double kRadius = 0.25e-3, kPressure = 2e6, kFriction = 0.4;
  static constexpr double kFast = 2.0 * M_PI * 3000.0;  ///< 180,000 r/min [rad/s]

  void Make(const Material& material, Cutting cutting, int samples = 1024) {
    cutting.samples = samples;
    TriangleMesh mesh = MakeBox(Vec3(2.4e-3, 1.6e-3, 0.8e-3));
    for (Vec3& v : mesh.vertices) v.z() -= 0.4e-3;
    const SolidGridOptions options{.spacing = 50e-6, .most_bytes = 64u << 20};
    CutSolid solid{std::make_shared<SolidGrid>(mesh, options, "block"), {}, {}};
    solid.materials.fill(material);
    const std::vector<Ball> tool{{Vec3::Zero(), 0.5 * kRadius}, {Vec3(0, 0, 0.02), kRadius}};
    const std::vector<Ball> far{{Vec3(1, 0, 0), 0.01}};
    tool_ = MakeTree(tool);
    objects_ = MakeTree(far);
    const PlacedTree placed{&objects_, {}};
    const StepParameters parameters{};
    model_ = std::make_unique<HapticModel>(
        tool_,
        std::make_shared<const SceneObjects>(std::span(&placed, 1), parameters.features.contact,
                                             std::vector{solid}),
        parameters, nullptr, cutting);
    state_ = StepState(*model_);
    workspace_ = std::make_unique<StepWorkspace>(*model_);
    whole_ = test::TotalLeft(state_.cut.fields[0]);
  }
  StepReport Step(const Pose& X_WH) {
    const StepReport report = HapticStep(*model_, X_WH, state_, *workspace_);
    EXPECT_EQ(report.faults & ~kFaultTargetFar, 0u);
    return report;
  }
  /// Volume removed so far [m^3].
  double Cut() const { return whole_ - test::TotalLeft(state_.cut.fields[0]); }
  StepReport Press(double to, double from = kRadius + 5e-6) {
    state_.X_WG = state_.X_WH = At(0, 0, from);
    StepReport report;
    for (double z = from; z > to; z -= 2e-6) report = Step(At(0, 0, z));
    return report;
  }
  /// The part of the hand's torque about the bur's axis, at the bur.
  double AxialTorque(const StepReport& report) const {
    const Vec3 lever = state_.X_WG.p - state_.X_WG * model_->reference();
    return (report.wrench.torque - lever.cross(report.wrench.force)).z();
  }
  static Cutting BallBur(double speed) {
    Cutting cutting{Bur::Ball(kRadius), {}};
    cutting.spin.speed = speed;
    return cutting;
  }

  SphereTree tool_, objects_;
  std::unique_ptr<HapticModel> model_;
  StepState state_;
  std::unique_ptr<StepWorkspace> workspace_;
  double whole_ = 0.0;
};

// Over the half ball ahead, p dA acts at distance r from the axis: mu p times the integral of r,
// pi^2 R^3 / 2.  Seen from above the bur turns clockwise, so the handle turns the other way.
TEST_F(Spin, OfABallThatPlungesTheHandFeelsTheTorqueAndNothingSideways) {
  Make(Cuttable(kPressure, 0.0, kFriction), BallBur(kFast));
  const StepReport report = Press(-0.7e-3);
  const double law = kFriction * kPressure * 0.5 * M_PI * M_PI * std::pow(kRadius, 3);
  EXPECT_NEAR(AxialTorque(report), law, 0.01 * law);
  EXPECT_NEAR(report.wrench.force.z(), kPressure * M_PI * kRadius * kRadius, 2e-3);
  EXPECT_LT(report.wrench.force.head<2>().norm(), 0.01 * report.wrench.force.z());
}

// A bur that mills along x, half of it in the block, is pressed at its front and dragged to the
// side that its front moves away from.
TEST_F(Spin, OfABallThatMillsTheHandFeelsThePullToTheSideAsTheLawHasIt) {
  for (const double sense : {1.0, -1.0}) {
    Make(Cuttable(kPressure, 0.0, kFriction), BallBur(kFast));
    StepReport report = Press(-0.35e-3);
    Vec3 from = Vec3::Zero();
    for (double x = 0.0; x < 0.8e-3; x += 3e-6) {
      from = state_.X_WG.p;
      report = Step(At(sense * x, 0, -0.35e-3));
    }
    const Vec3 way = (state_.X_WG.p - from).normalized();
    EXPECT_GT(sense * way.x(), 0.8);
    Vec3 law = Vec3::Zero();
    for (const BurSample& s : Bur::Ball(kRadius).Samples(20000)) {
      if (s.normal.dot(way) <= 0.0 || state_.X_WG.p.z() + s.point.z() >= 0.0) continue;
      const Vec3 slide = Vec3(s.point.y(), -s.point.x(), 0.0).normalized();
      law -= s.area * kPressure * (s.normal + kFriction * slide);
    }
    EXPECT_GT(sense * law.y(), 0.1 * law.norm());
    EXPECT_LT((report.wrench.force - law).norm(), 0.03 * law.norm())
        << report.wrench.force.transpose() << " and " << law.transpose();
  }
}

// Against the wall of its hole, drag would carry a bur with high friction round the wall.
TEST_F(Spin, ABurThatLeansAgainstAWallDoesNotWhirl) {
  Make(Cuttable(kPressure, 0.5e9, 1.0), BallBur(kFast), 256);
  Press(-0.6e-3);
  Vec3 last = Vec3::Zero();
  double change = 0.0;
  for (int n = 0; n < 400; ++n) {
    const StepReport report = Step(At(1e-6 * std::min(n, 200), 0, -0.6e-3));
    if (n > 0) change = std::max(change, (report.wrench.force - last).norm());
    last = report.wrench.force;
  }
  EXPECT_LT(change, 0.02);
  const StepReport report = Step(At(0.2e-3, 0, -0.6e-3));
  EXPECT_LT((report.wrench.force - last).norm(), 1e-3);
}

// The motor does the work of the drag; the material itself never gives work.
TEST_F(Spin, GivesTheHandNoMoreWorkThanTheMotorDoes) {
  for (const std::uint64_t seed : {21, 22}) {
    test::Random random(seed);
    Make(Cuttable(kPressure, 0.5e9, 0.9), BallBur(kFast), 128);
    Pose hand = At(0, 0, kRadius + 20e-6), towards = hand;
    state_.X_WG = state_.X_WH = hand;
    int judged = 0;
    for (int n = 0; n < 600; ++n) {
      if (n % 60 == 0) {
        towards.p = Vec3(0, 0, -0.1e-3) + random.InCube(0.4e-3);
        towards.q = Quat(Eigen::AngleAxisd(random.Uniform(0.0, 0.2), random.Direction()));
      }
      hand.p += 0.05 * (towards.p - hand.p);
      hand.q = hand.q.slerp(0.05, towards.q);
      const Pose before = state_.X_WG;
      const Vec6 drag = state_.cut.drag;
      const StepReport report = Step(hand);
      // Each sub-step has its own force, and a bur that nothing holds has no drag.
      if (report.diagnostics.substeps > 1 || report.wrench.force.isZero(0.0)) continue;
      ++judged;
      const double k = model_->parameters().stiffness, rho = model_->rotation_length();
      const Vec3 v = state_.X_WG * model_->reference() - before * model_->reference();
      const Vec3 phi = RotationLog(state_.X_WG.q * before.q.conjugate());
      const Vec3 force(drag[0], drag[1], drag[2]), turn(drag[3], drag[4], drag[5]);
      const double motor = k * (force.dot(v) + rho * turn.dot(phi));
      EXPECT_LE(report.wrench.force.dot(v) + report.wrench.torque.dot(phi), motor + 1e-12) << n;
      // At most the law's force over the whole bur.
      EXPECT_LT(k * force.norm(), 0.9 * 4.0 * M_PI * kRadius * kRadius * (kPressure + 0.5e9 * 0.1));
    }
    EXPECT_GT(Cut(), 0.0);
    EXPECT_GT(judged, 300);
  }
}

TEST_F(Spin, WithoutFrictionChangesNoBit) {
  std::vector<Vec3> forces;
  for (const double speed : {0.0, kFast}) {
    Make(Cuttable(kPressure, 0.5e9), BallBur(speed), 256);
    Press(-0.3e-3);
    for (int n = 0; n < 50; ++n) {
      const Vec3 force = Step(At(2e-6 * n, 0, -0.3e-3)).wrench.force;
      if (speed == 0.0) {
        forces.push_back(force);
      } else {
        EXPECT_EQ(force, forces[static_cast<std::size_t>(n)]) << n;
      }
    }
  }
}

TEST_F(Spin, ADeadTipStopsWhatTheSideCuts) {
  Cutting cutting{Bur::Cylinder(0.3e-3, 2e-3, 0.0), {}};
  cutting.dead_tip = 1e-6;  // the flat end
  Make(Cuttable(kPressure, 0.0), cutting);
  Press(-1e-3, 5e-6);
  EXPECT_NEAR(state_.X_WG.p.z(), 0.0, 5e-6);
  // Within the grid's error of the face.
  const double skin = 0.3e-6 * M_PI * 0.09e-6;
  EXPECT_LT(Cut(), skin);
  const double before = Cut();
  for (int n = 0; n < 500; ++n) Step(At(0, 0, -1e-3));
  EXPECT_LT(Cut() - before, 0.01 * skin);
  whole_ = test::TotalLeft(state_.cut.fields[0]);
  // Beside the block and below its face it mills sideways.
  state_.ForgetContact();
  state_.X_WG = state_.X_WH = At(-1.6e-3, 0, -0.4e-3);
  for (double x = -1.6e-3; x < 0.0; x += 3e-6) Step(At(x, 0, -0.4e-3));
  const double in = state_.X_WG.p.x() + 0.3e-3 + 1.2e-3;
  ASSERT_GT(in, 0.4e-3);
  const double rounded = (in - 0.3e-3) * 0.6e-3 + 0.5 * M_PI * 0.09e-6;
  EXPECT_NEAR(state_.X_WG.p.z(), -0.4e-3, 5e-6);
  EXPECT_NEAR(Cut(), rounded * 0.4e-3, 0.02 * rounded * 0.4e-3);
}

// 240 teeth per second: in 50 ms the force oscillates twelve times about its value without
// vibration.
TEST_F(Spin, AVibrationShakesTheHandleAsTeethPassAndMovesNothing) {
  std::vector<Vec3> still;
  for (const double vibration : {0.0, 0.2}) {
    Cutting cutting = BallBur(kFast);
    cutting.spin.vibration = vibration;
    cutting.spin.tooth_Hz = 240.0;
    Make(Cuttable(kPressure, 0.5e9), cutting, 256);
    Press(-0.5e-3);
    double sum = 0.0, most = 0.0;
    int turns = 0;
    for (int n = 0; n < 50; ++n) {
      const StepReport report = Step(At(0, 0, -0.5e-3 - 2e-6 * n));
      still.push_back(report.X_WG.p);
      if (vibration == 0.0) continue;
      EXPECT_EQ(report.X_WG.p, still[static_cast<std::size_t>(n)]);
      const double force = report.bur_force.z();
      const double shake = report.wrench.force.z() / force - 1.0;
      turns += (shake < 0.0) != (sum < 0.0) && n > 0;
      sum = shake;
      most = std::max(most, std::abs(shake));
    }
    if (vibration == 0.0) continue;
    EXPECT_NEAR(turns, 24, 2);
    EXPECT_GT(most, 0.18);
    EXPECT_LE(most, 0.2 + 1e-6);
  }
}

TEST_F(Spin, StepsWithoutAskingForMemory) {
  Make(Cuttable(kPressure, 0.5e9, kFriction), BallBur(kFast), 256);
  state_.X_WG = state_.X_WH = At(0, 0, kRadius);
  const std::uint64_t before = test::AllocationsOfThisThread();
  for (int n = 0; n < 200; ++n) {
    state_.cut.spins = n % 50 != 49;
    HapticStep(*model_, At(1e-6 * n, 0, kRadius - 2e-6 * n), state_, *workspace_);
  }
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
}

}  // namespace
}  // namespace palpate
