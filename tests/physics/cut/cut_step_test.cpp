#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "server/physics/haptic_step.h"
#include "server/physics/start_pose.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/random.h"
#include "tests/support/step_bench.h"
#include "tests/support/test_scenes.h"
#include "tests/support/volume_left.h"

namespace palpate {
namespace {

using test::At;
using test::Ball;
using test::MakeTree;

constexpr double kBurRadius = 0.25e-3, kCoupling = 1000.0;
const Material kDentine{.cutting_pressure = 2e6, .cutting_viscosity = 0.5e9};

/// A block of 2.4 x 1.6 x 0.8 mm with its top at z = 0, a tool with a ball bur, and rigid balls.
class CutStep : public testing::Test {
 protected:
  void Make(std::vector<Ball> tool, std::vector<Ball> rigid, const Material& material = kDentine,
            int samples = 1024, const Quat& q_WB = Quat::Identity(),
            const TriangleMesh* mesh_of_rigid = nullptr) {
    const Cutting cutting{Bur::Ball(kBurRadius), {}, samples};
    TriangleMesh mesh = MakeBox(Vec3(2.4e-3, 1.6e-3, 0.8e-3));
    for (Vec3& v : mesh.vertices) v = q_WB.conjugate() * (v - Vec3(0, 0, 0.4e-3));
    CutSolid solid{std::make_shared<SolidGrid>(
                       mesh, SolidGridOptions{.spacing = 50e-6, .most_bytes = 64u << 20}, "block"),
                   {Vec3::Zero(), q_WB},
                   {}};
    solid.materials.fill(material);
    tool_ = MakeTree(tool);
    if (!rigid.empty()) objects_ = MakeTree(rigid);
    PlacedTree placed{&objects_, {}};
    StepParameters parameters{.stiffness = kCoupling};
    if (mesh_of_rigid != nullptr) {
      objects_ = test::MakeBody("rigid", *mesh_of_rigid, 64).tree;
      placed.mesh = mesh_of_rigid;
      parameters.features.contact = ContactModel::kSurface;
    }
    model_ = std::make_unique<HapticModel>(
        tool_,
        std::make_shared<const SceneObjects>(std::span(&placed, 1), parameters.features.contact,
                                             std::vector{solid}),
        parameters, nullptr, cutting);
    state_ = std::make_unique<StepState>(*model_);
    workspace_ = std::make_unique<StepWorkspace>(*model_);
    whole_ = test::TotalLeft(state_->cut.fields[0]);
  }
  /// Volume removed so far [m^3].
  double Cut() const { return whole_ - test::TotalLeft(state_->cut.fields[0]); }
  StepReport Step(const Pose& X_WH) {
    const StepReport report = HapticStep(*model_, X_WH, *state_, *workspace_);
    EXPECT_EQ(report.faults, 0u);
    return report;
  }
  void Start(const Pose& X_WG) { state_->X_WG = state_->X_WH = X_WG; }

  SphereTree tool_, objects_;
  std::unique_ptr<HapticModel> model_;
  std::unique_ptr<StepState> state_;
  std::unique_ptr<StepWorkspace> workspace_;
  double whole_ = 0.0;
};

const std::vector<Ball> kBur{{Vec3::Zero(), kBurRadius}};
const std::vector<Ball> kFarAway{{Vec3(1, 0, 0), 0.01}};

TEST_F(CutStep, APlungeHasTheLawsForceAndTakesTheSweptVolume) {
  Make(kBur, kFarAway);
  double z = kBurRadius + 10e-6;
  Start(At(0, 0, z));
  for (; z > -1e-3; z -= 2e-6) {
    const double before = state_->X_WG.p.z();
    const StepReport report = Step(At(0, 0, z));
    const double at = state_->X_WG.p.z();
    // The half sphere ahead at speed u: p0 pi R^2 + kappa u 2/3 pi R^2.
    if (at > 0.0) continue;
    const double speed = (before - at) / 1e-3;
    const double law = M_PI * kBurRadius * kBurRadius *
                       (kDentine.cutting_pressure + kDentine.cutting_viscosity * speed / 1.5);
    ASSERT_NEAR(report.wrench.force.z(), law, 0.005 * law);
    if (at < -0.3e-3) break;
  }
  const double depth = -state_->X_WG.p.z();
  ASSERT_GT(depth, 0.29e-3);
  const double swept = M_PI * kBurRadius * kBurRadius * (depth + kBurRadius / 1.5);
  EXPECT_NEAR(Cut(), swept, 0.005 * swept);
}

// The bur is at the end of a handle: the reference point feels its force through a lever.
TEST_F(CutStep, ALeverFeelsTheTorqueAboutItsReference) {
  const Vec3 end(0.01, 0, 0.02);
  Make({{Vec3::Zero(), kBurRadius}, {end, kBurRadius}}, kFarAway);
  Start(At(0, 0, kBurRadius + 10e-6));
  StepReport report;
  for (double z = kBurRadius; z > -0.6e-3; z -= 2e-6) report = Step(At(0, 0, z));
  EXPECT_GT(report.wrench.force.z(), 0.3);
  const Vec3 lever = state_->X_WG.p - state_->X_WG * model_->reference();
  EXPECT_GT(lever.norm(), 0.01);
  EXPECT_LT((report.wrench.torque - lever.cross(report.wrench.force)).norm(),
            0.01 * report.wrench.torque.norm());
}

TEST_F(CutStep, StopsAtARigidBodyInTheMaterial) {
  Make(kBur, {{Vec3(0, 0, -1.3e-3), 1e-3}});
  Start(At(0, 0, kBurRadius + 10e-6));
  StepReport report;
  for (double z = kBurRadius; z > -1e-3; z -= 2e-6) report = Step(At(0, 0, z));
  EXPECT_NEAR(state_->X_WG.p.z(), -0.3e-3 + kBurRadius, 1e-9);
  ASSERT_EQ(report.contacts, 1);
  // At rest the wall and the material share the hand's force; the material has at most p0 pi R^2.
  const double rests = kDentine.cutting_pressure * M_PI * kBurRadius * kBurRadius;
  EXPECT_NEAR(report.wrench.force.z(), kCoupling * (-0.05e-3 + 1e-3), 3e-3);
  EXPECT_LE(report.wrench.force.z() - report.active[0].force, 1.01 * rests);
  EXPECT_GE(report.wrench.force.z() - report.active[0].force, -1e-9);
  const double before = Cut();
  for (int i = 0; i < 200; ++i) Step(At(0, 0, -1e-3));
  EXPECT_LT(Cut() - before, 1e-6 * before);
}

TEST_F(CutStep, StopsAtAMeshInTheMaterial) {
  TriangleMesh floor = MakeBox(Vec3(0.01, 0.01, 0.01));
  for (Vec3& v : floor.vertices) v.z() -= 5.3e-3;
  Make(kBur, {}, kDentine, 256, Quat::Identity(), &floor);
  Start(At(0, 0, kBurRadius + 10e-6));
  StepReport report;
  for (double z = kBurRadius; z > -1e-3; z -= 2e-6) report = Step(At(0, 0, z));
  const double gap = state_->X_WG.p.z() - kBurRadius + 0.3e-3;
  EXPECT_GT(gap, 0.0);
  EXPECT_LT(gap, 2.0 * limits::mesh::kSeparation);
  EXPECT_GE(report.contacts, 1);
  EXPECT_NEAR(report.wrench.force.z(), kCoupling * (-0.05e-3 + 1e-3), 5e-3);
}

TEST_F(CutStep, BelowTheThresholdItRestsAndWhatIsCutStaysFree) {
  Make(kBur, kFarAway, {.cutting_pressure = 50e6, .cutting_viscosity = 1e9});
  Start(At(0, 0, kBurRadius));
  for (int i = 0; i < 400; ++i) Step(At(0, 0, kBurRadius - 0.5e-3));
  // 0.5 N at 50 MPa is an area of 0.01 mm^2: a cap of height A / (2 pi R).
  const double rest = state_->X_WG.p.z();
  EXPECT_NEAR(kBurRadius - rest, 0.01e-6 / (2.0 * M_PI * kBurRadius), 3e-6);
  for (double z = kBurRadius; z < 0.5e-3; z += 5e-6) Step(At(0, 0, z));
  EXPECT_EQ(Step(At(0, 0, 0.5e-3)).wrench.force.norm(), 0.0);
  // Back into its own hollow without a force.
  StepReport report;
  for (double z = 0.5e-3; z > rest + 1e-6; z -= 5e-6) report = Step(At(0, 0, z));
  EXPECT_LT(report.wrench.force.norm(), 1e-3);
}

TEST_F(CutStep, GoesOnAlikeFromACopyAndInATurnedGrid) {
  const auto way = [](int n) { return At(2e-6 * n, 0, 0.2e-3 - 2e-6 * std::min(n, 200)); };
  Make(kBur, kFarAway, kDentine, 256);
  Start(At(0, 0, kBurRadius));
  for (int n = 0; n < 250; ++n) Step(way(n));
  StepState copy = *state_;
  std::vector<Vec3> forces;
  for (int n = 250; n < 350; ++n) {
    const StepReport report = Step(way(n));
    forces.push_back(report.wrench.force);
    const StepReport again = HapticStep(*model_, way(n), copy, *workspace_);
    EXPECT_EQ(again.wrench.force, report.wrench.force);
    EXPECT_EQ(copy.cut.fields[0].changes(), state_->cut.fields[0].changes());
  }
  Make(kBur, kFarAway, kDentine, 256, Quat(Eigen::AngleAxisd(0.5, Vec3::UnitZ())));
  Start(At(0, 0, kBurRadius));
  for (int n = 0; n < 350; ++n) {
    const Vec3 force = Step(way(n)).wrench.force;
    if (n < 250) continue;
    const Vec3& along = forces[static_cast<std::size_t>(n - 250)];
    EXPECT_LT((force - along).norm(), 0.01 * along.norm()) << n;
  }
}

TEST_F(CutStep, StartsOutsideOfASolidThatIsWhole) {
  Make(kBur, kFarAway);
  const StartPose start = ResolveStart(*model_, At(0.1e-3, 0, -0.2e-3), *workspace_);
  EXPECT_NEAR(start.X_WG.p.z(), kBurRadius, 30e-6);
  EXPECT_NEAR(start.depth, 0.45e-3, 30e-6);
  const StartPose apart = ResolveStart(*model_, At(0, 0, 1e-3), *workspace_);
  EXPECT_EQ(apart.depth, 0.0);
}

TEST_F(CutStep, StepsWithoutAskingForMemory) {
  Make(kBur, kFarAway, kDentine, 256);
  Start(At(0, 0, kBurRadius));
  const std::uint64_t before = test::AllocationsOfThisThread();
  for (int n = 0; n < 200; ++n) {
    HapticStep(*model_, At(1e-6 * n, 0, kBurRadius - 2e-6 * n), *state_, *workspace_);
  }
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
}

// The end of the handle goes 0.2 mm in a cycle, the bur 2 um.
TEST_F(CutStep, FollowsAHandThatTiltsABurAboutItsTipInOneSubStep) {
  Make({{Vec3::Zero(), kBurRadius}, {Vec3(0, 0, 0.04), kBurRadius}}, kFarAway, kDentine, 256);
  Start(At(0, 0, kBurRadius + 10e-6));
  for (double z = kBurRadius; z > -0.1e-3; z -= 2e-6) Step(At(0, 0, z));
  for (int n = 0; n < 60; ++n) {
    const StepReport report =
        Step({Vec3(2e-6 * n, 0, -0.1e-3), RotationExp(5e-3 * n * Vec3::UnitY())});
    ASSERT_EQ(report.diagnostics.substeps, 1) << n;
  }
}

// After a jump the tool needs several cycles, and is near the material before it reaches it.
TEST_F(CutStep, NothingIsFeltOfMaterialThatTheNextSubStepDoesNotComeTo) {
  TriangleMesh far = MakeBox(Vec3(0.01, 0.01, 0.01));
  for (Vec3& v : far.vertices) v.z() -= 30e-3;
  Make(kBur, {}, kDentine, 256, Quat::Identity(), &far);
  Start(At(-1e-3, 0, kBurRadius + 0.14e-3));
  int above = 0;
  for (int n = 0; n < 20; ++n) {
    const StepReport report =
        HapticStep(*model_, At(1e-3, 0, kBurRadius - 1e-3), *state_, *workspace_);
    if (state_->X_WG.p.z() <= kBurRadius + 75e-6) continue;  // half the band
    ++above;
    EXPECT_EQ(report.wrench.force.norm(), 0.0) << n << ": " << state_->X_WG.p.transpose();
  }
  EXPECT_GT(above, 0);
  EXPECT_GT(Cut(), 0.0);
}

// Any hand in six degrees of freedom, beside rigid balls: steps are solved and never return work.
TEST_F(CutStep, NoHandGetsWorkOutOfTheMaterial) {
  for (const std::uint64_t seed : {11, 12, 13}) {
    test::Random random(seed);
    Make({{Vec3::Zero(), kBurRadius}, {Vec3(0.005, 0, 0.02), kBurRadius}},
         {{Vec3(0, 0, -1.3e-3), 1e-3}}, kDentine, 64);
    Pose hand = At(0, 0, kBurRadius + 20e-6), towards = hand;
    int judged = 0;
    Start(hand);
    for (int n = 0; n < 600; ++n) {
      if (n % 60 == 0) {
        towards.p = Vec3(0, 0, -0.1e-3) + random.InCube(0.4e-3);
        towards.q = Quat(Eigen::AngleAxisd(random.Uniform(0.0, 0.2), random.Direction()));
      }
      hand.p += 0.05 * (towards.p - hand.p);
      hand.q = hand.q.slerp(0.05, towards.q);
      const Pose before = state_->X_WG;
      const StepReport report = Step(hand);
      if (report.contacts > 0 || report.diagnostics.substeps > 1)
        continue;  // each sub-step has its own force
      ++judged;
      const Vec3 v = state_->X_WG * model_->reference() - before * model_->reference();
      const Vec3 phi = RotationLog(state_->X_WG.q * before.q.conjugate());
      EXPECT_LE(report.wrench.force.dot(v) + report.wrench.torque.dot(phi), 1e-12)
          << seed << ", " << n;
    }
    EXPECT_GT(Cut(), 0.0);
    EXPECT_GT(judged, 300);
  }
}

}  // namespace
}  // namespace palpate
