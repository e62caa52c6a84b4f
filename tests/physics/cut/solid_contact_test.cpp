#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/grid/solid_surface.h"
#include "scenes/shapes/bur_shapes.h"
#include "scenes/shapes/shapes.h"
#include "server/physics/haptic_step.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/mesh_oracle.h"
#include "tests/support/random.h"
#include "tests/support/step_bench.h"
#include "tests/support/test_scenes.h"

namespace palpate {
namespace {

using test::At;
using test::MeshOracle;
using test::Random;

const Vec3 kSize(2.4e-3, 1.6e-3, 1.2e-3);
const Quat kAskew = RotationExp(Vec3(0.3, -0.5, 0.4));
constexpr double kDelta = limits::mesh::kSeparation;

/// A block with its top at z = 0 in W, whatever the orientation of its lattice.
Body Block(const Quat& q_WB = Quat::Identity(), double spacing = 50e-6) {
  TriangleMesh mesh = MakeBox(kSize);
  for (Vec3& v : mesh.vertices) v = q_WB.conjugate() * (v - Vec3(0, 0, 0.5 * kSize.z()));
  Body block = test::MakeMeshBody("block", std::move(mesh), {Vec3::Zero(), q_WB});
  block.grid.emplace().spacing = spacing;
  block.materials = {{.cutting_pressure = 0.3e6, .cutting_viscosity = 0.05e9}};
  block.leaf_material.assign(block.tree.leaves(), 0);
  return block;
}

/// A tool alone with one such block.
struct Felt {
  Felt(Body tool, Body block, FrictionModel friction = FrictionModel::kOff) {
    scene.name = "test";
    scene.tools.push_back(std::move(tool));
    scene.objects.push_back(std::move(block));
    scene.features.friction = friction;
    model.emplace(MakeModel(scene, scene.tools.front(), MakeObjects(scene)));
    state.emplace(*model);
    workspace.emplace(*model);
  }
  void Start(const Pose& X) {
    state->X_WG = state->X_WH = X;
    state->ForgetContact();
  }
  StepReport Step(const Pose& X_WH) {
    const StepReport report = HapticStep(*model, X_WH, *state, *workspace);
    EXPECT_EQ(report.faults & ~kFaultTargetFar, 0u);
    return report;
  }
  /// Cuts with another bur from one point of W to another.
  void Groove(const Bur& bur, const Vec3& from, const Vec3& to, double length = 5e-6) {
    const int steps = std::max(1, static_cast<int>(std::ceil((to - from).norm() / length)));
    const Pose X_BW = model->solids()[0].X_WB.Inverse();
    const Vec3 step = (to - from) / steps;
    for (int n = 0; n < steps; ++n) {
      state->cut.fields[0].Remove(bur, X_BW * Pose{from + n * step, Quat::Identity()},
                                  X_BW.q * step);
    }
  }
  /// An oracle of the drawn surface against the tool, or a part of it.
  MeshOracle Oracle() const { return Oracle(scene.tools.front().mesh); }
  MeshOracle Oracle(const TriangleMesh& tool) const {
    const SolidSurface surface = WholeSurface(state->cut.fields[0]);
    const TriangleMesh left{surface.vertices, surface.triangles};
    const MeshOracle::PlacedMesh placed{&left, model->solids()[0].X_WB};
    return MeshOracle(tool, std::span(&placed, 1));
  }

  Scene scene;
  std::optional<HapticModel> model;
  std::optional<StepState> state;
  std::optional<StepWorkspace> workspace;
};

/// A pointed tool, 2 mm long, its tip at the origin.
Body Probe() {
  TriangleMesh mesh = MakeBox(Vec3(0.4e-3, 0.3e-3, 2e-3));
  for (Vec3& v : mesh.vertices) {
    v.z() += 1e-3;
    if (v.z() < 1e-3) v = Vec3(0.1 * v.x(), 0.1 * v.y(), v.z());
  }
  return test::MakeMeshBody("probe", std::move(mesh));
}
Body Foot() {
  TriangleMesh mesh = MakeBox(Vec3(0.35e-3, 0.31e-3, 1e-3));
  for (Vec3& v : mesh.vertices) v.z() += 0.5e-3;
  return test::MakeMeshBody("foot", std::move(mesh));
}
Body BurBody(const BurProfile& profile) {
  Body bur = test::MakeMeshBody("bur", MakeBur(profile, 8e-3));
  bur.bur = profile;
  return bur;
}

void Riddle(Felt& felt, std::uint64_t seed) {
  Random random(seed);
  for (int n = 0; n < 12; ++n) {
    const Vec3 from = random.InCube(1e-3) - Vec3(0, 0, 0.3e-3);
    felt.Groove(Bur::Ball(random.Uniform(0.15e-3, 0.4e-3)), from,
                from + random.Uniform(0.0, 0.8e-3) * random.Direction(), 20e-6);
  }
}

/// Presses and drags at random over what is left, and into it.
class Hand {
 public:
  explicit Hand(std::uint64_t seed) : random_(seed) {}
  Pose Next() {
    if (n_++ % 80 == 0) {
      towards_.p = random_.InCube(1.1e-3) - Vec3(0, 0, 0.5e-3);
      towards_.q = RotationExp(random_.Uniform(0.0, 1.5) * random_.Direction());
    }
    at_.p += 0.03 * (towards_.p - at_.p);
    at_.q = at_.q.slerp(0.03, towards_.q);
    return at_;
  }
  static Pose First() { return At(0, 0, 0.5e-3); }

 private:
  Random random_;
  int n_ = 0;
  Pose at_ = First(), towards_;
};

// What is drawn is what is felt: the tool never meets a drawn triangle.
TEST(SolidContact, NoHandTakesAToolIntoWhatIsDrawn) {
  for (const bool askew : {false, true}) {
    for (const std::uint64_t seed : {1, 2}) {
      Felt felt(Probe(), Block(askew ? kAskew : Quat::Identity()));
      Riddle(felt, seed);
      felt.Start(Hand::First());
      const MeshOracle oracle = felt.Oracle();
      Hand hand(seed);
      int touched = 0;
      for (int n = 0; n < 600; ++n) {
        const StepReport report = felt.Step(hand.Next());
        ASSERT_FALSE(oracle.Meet(report.X_WG)) << seed << ", " << n;
        touched += report.contacts > 0;
      }
      EXPECT_GT(touched, 100);
    }
  }
}

// A pair apart from a block's box must be apart from whatever is ever left in it.
TEST(SolidContact, ABlocksBoxHoldsWhateverIsLeftOfIt) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Felt felt(Probe(), Block(seed == 1 ? Quat::Identity() : kAskew));
    const CutSolid& solid = felt.model->solids()[0];
    const ContactBody blocks = BlocksOf(solid);
    const HullTree& boxes = blocks.shape->tree;
    if (seed > 1) Riddle(felt, seed);
    SolidSurface surface;
    std::size_t triangles = 0;
    std::vector<HullTree::Node> open{boxes.root()};
    while (!open.empty()) {
      const HullTree::Node n = open.back();
      const HullTree::Inner& box = boxes.inner(n);
      open.pop_back();
      if (boxes.BlockOf(n) < 0) {
        open.insert(open.end(), box.child, box.child + 2);
        continue;
      }
      TakeSurface(*solid.grid, felt.state->cut.fields[0].field(),
                  static_cast<std::size_t>(boxes.BlockOf(n)), surface);
      triangles += surface.triangles.size();
      for (const auto& triangle : surface.triangles) {
        for (const std::uint32_t v : triangle) {
          const Vec3 from = surface.vertices[v] - box.centre;
          for (int c = 0; c < 3; ++c) {
            const Vec3 side = boxes.HullOf(n).box->sides.col(c);
            ASSERT_LE(std::abs(from.dot(side)), side.squaredNorm()) << boxes.BlockOf(n);
          }
        }
      }
    }
    EXPECT_EQ(triangles, WholeSurface(felt.state->cut.fields[0]).triangles.size());
  }
}

/// The drawn surface as one mesh, without blocks.
struct AsMesh {
  explicit AsMesh(const Felt& felt) {
    const SolidSurface surface = WholeSurface(felt.state->cut.fields[0]);
    scene = test::MeshScene(felt.scene.tools[0].mesh, {surface.vertices, surface.triangles});
    Body& object = scene.objects[0];
    object.X_WB = felt.scene.objects[0].X_WB;
    object.materials = felt.scene.objects[0].materials;
    object.leaf_material.assign(object.tree.leaves(), 0);
    scene.features = felt.scene.features;
    model.emplace(MakeModel(scene, scene.tools.front(), MakeObjects(scene)));
    state.emplace(*model);
    workspace.emplace(*model);
    state->X_WG = state->X_WH = felt.state->X_WG;
  }
  Scene scene;
  std::optional<HapticModel> model;
  std::optional<StepState> state;
  std::optional<StepWorkspace> workspace;
};

// A flat face has no borders between blocks: a sliding tool feels only the hand's push.
TEST(SolidContact, AFaceHasNoBordersBetweenBlocks) {
  Felt felt(Foot(), Block());
  felt.Start(At(-0.8e-3, -0.4e-3, 10e-6));
  for (int n = 0; n < 1500; ++n) {
    const double z = -0.2e-3 * std::min(1.0, n / 100.0);
    const StepReport report = felt.Step(At(-0.8e-3 + 1e-6 * n, -0.4e-3 + 0.53e-6 * n, z));
    if (n < 10) continue;  // the first steps look into the blocks
    ASSERT_LT(report.wrench.force.head<2>().norm(), 1e-4) << n;
    ASSERT_NEAR(report.wrench.force.z(), 1e3 * (kDelta - z), 1e-3) << n;
    // Its contacts lie under the foot.
    ASSERT_LT(report.wrench.torque.norm(), 0.24e-3 * report.wrench.force.z() + 1e-7) << n;
  }
}

// Over grooves and their rims a tool may hop to one point or another; otherwise it feels the same
// as on one mesh of the same triangles.
TEST(SolidContact, FeelsAsTheSameTrianglesOfAMesh) {
  Felt felt(Probe(), Block(kAskew));
  Riddle(felt, 5);
  felt.Start(Hand::First());
  AsMesh mesh(felt);
  Hand hand(5);
  std::vector<double> difference;
  for (int n = 0; n < 600; ++n) {
    const Pose X_WH = hand.Next();
    const StepReport is = felt.Step(X_WH);
    const StepReport was = HapticStep(*mesh.model, X_WH, *mesh.state, *mesh.workspace);
    if (was.contacts > 0) difference.push_back((is.wrench.force - was.wrench.force).norm());
  }
  ASSERT_GT(difference.size(), 300u);
  std::ranges::sort(difference);
  EXPECT_LT(difference[difference.size() / 2], 1e-3);
  EXPECT_LT(difference[difference.size() * 4 / 5], 5e-3);
}

TEST(SolidContact, RubsWithTheFrictionOfItsMaterial) {
  Body block = Block();
  block.materials[0].static_friction = block.materials[0].dynamic_friction = 0.4;
  Felt felt(test::BallBody(0.2e-3), block, FrictionModel::kCoulomb);
  felt.Start(At(-0.6e-3, 0, 0.21e-3));
  for (int n = 0; n < 1000; ++n) {
    const StepReport report =
        felt.Step(At(-0.6e-3 + 1e-6 * n, 0, 0.2e-3 - 0.2e-3 * std::min(1.0, n / 100.0)));
    if (n < 200) continue;
    ASSERT_NEAR(report.wrench.force.z(), 0.2, 2e-3) << n;
    ASSERT_NEAR(report.wrench.force.x(), -0.4 * report.wrench.force.z(), 2e-3) << n;
  }
}

// While another bur cuts below it, the tool never enters the surface, and rests on it in the end.
TEST(SolidContact, FollowsWhatIsCutBelowAProbe) {
  Felt felt(Probe(), Block(kAskew));
  felt.Start(At(0.1e-3, 0, 20e-6));
  const Pose hand = At(0.1e-3, 0, -0.9e-3);
  for (int n = 0; n < 50; ++n) felt.Step(hand);
  EXPECT_NEAR(felt.state->X_WG.p.z(), kDelta, 0.2e-6);
  for (int n = 0; n < 200; ++n) {
    const double z = 0.3e-3 - 4e-6 * n;
    felt.Groove(Bur::Ball(0.3e-3), Vec3(0.1e-3, 0, z), Vec3(0.1e-3, 0, z - 4e-6));
    felt.Step(hand);
    if (n % 40 == 0) {
      // New triangles may stand proud of the old ones by a chord's height.
      ASSERT_LT(felt.Oracle().At(felt.state->X_WG).depth, 1e-6) << n;
    }
  }
  for (int n = 0; n < 200; ++n) felt.Step(hand);
  EXPECT_FALSE(felt.Oracle().Meet(felt.state->X_WG));
  EXPECT_LT(felt.Oracle().Distance(felt.state->X_WG).distance, 2.0 * kDelta);
  EXPECT_LT(felt.state->X_WG.p.z(), -0.75e-3);
  // Compare with a tool that arrives after all cutting.
  Felt after(Probe(), Block(kAskew));
  after.state->cut.fields = felt.state->cut.fields;
  after.Start(At(0.1e-3, 0, 20e-6));
  StepReport now, then;
  for (int n = 0; n < 400; ++n) {
    now = felt.Step(hand);
    then = after.Step(hand);
  }
  // It may lie on another facet at the bottom of the cut, but equally near.
  EXPECT_NEAR((now.X_WG.p - hand.p).norm(), (then.X_WG.p - hand.p).norm(), 0.5e-6);
}

// A ball on a neck with a collar: the head sinks in until the collar stops at the face, then cuts
// sideways until the neck stops at the wall of its hole.
TEST(SolidContact, ABursShankStopsWhereItsHeadDoesNot) {
  const BurProfile profile = BallBur(0.25e-3);
  Body bur = BurBody(profile);
  TriangleMesh collar = MakeBox(Vec3(1e-3, 0.2e-3, 0.8e-3));
  const auto first = static_cast<std::uint32_t>(bur.mesh.vertices.size());
  for (Vec3& v : collar.vertices) v.y() += 0.8e-3;
  for (const Vec3& v : collar.vertices) bur.mesh.vertices.push_back(v);
  for (const auto& [i, j, k] : collar.triangles) {
    bur.mesh.triangles.push_back({i + first, j + first, k + first});
  }
  Felt felt(bur, Block());
  const Quat q = RotationBetween(Vec3::UnitY(), Vec3::UnitZ());
  felt.Start({Vec3(-0.2e-3, 0, 20e-6), q});
  StepReport report;
  for (int n = 0; n < 1000; ++n) {
    const double x = std::max(0, n - 600) * 1e-6, z = std::min(n, 600) * 2e-6;
    report = felt.Step({Vec3(-0.2e-3 + x, 0, 20e-6 - z), q});
    if (n % 250 == 249) {
      EXPECT_FALSE(felt.Oracle(collar).Meet(report.X_WG)) << n;
    }
  }
  EXPECT_NEAR(report.X_WG.p.z(), -0.7e-3, 5e-6);
  EXPECT_GE(report.contacts, 1);
  // The hole's radius minus the neck's, and how far the tool tilts.
  EXPECT_NEAR(report.X_WG.p.x(), -0.2e-3 + 0.1e-3, 0.02e-3);
}

// A bar's edge that the head leaves beside its neck is made anew in each turn, and may then stand
// out into the neck.  No triangle of it may keep the tool.
TEST(SolidContact, ABurThatWasPushedThroughABarComesOutWithItsHand) {
  TriangleMesh mesh = MakeBox(Vec3(8e-3, 0.6e-3, 0.8e-3));
  Body bar = test::MakeMeshBody("bar", std::move(mesh));
  bar.grid.emplace().spacing = 50e-6;
  bar.materials = {{.cutting_pressure = 0.5e6}};
  bar.leaf_material.assign(bar.tree.leaves(), 0);
  for (const double beside : {0.1e-3, 0.15e-3, 0.2e-3}) {
    Felt felt(BurBody(BallBur(0.7e-3)), bar);
    felt.Start(At(-0.6e-3, 0.4e-3, beside));
    int away = 0;
    StepReport report;
    for (int n = 0; n < 640; ++n) {
      const Vec3 hand(-0.6e-3, 0.4e-3 - 6e-6 * std::min(n, 640 - n), beside);
      const Vec3 was = felt.state->X_WG.p;
      report = felt.Step({hand});
      away += (report.X_WG.p - hand).norm() > 0.5e-3 && (report.X_WG.p - was).norm() < 1e-9;
    }
    EXPECT_EQ(away, 0) << beside;
    EXPECT_LT(report.wrench.force.norm(), 0.01) << beside;
  }
}

// At rest a bur is a rigid tool.
TEST(SolidContact, ABurThatStandsStillCutsNothing) {
  const BurProfile profile = BallBur(0.25e-3);
  Felt felt(BurBody(profile), Block());
  const Quat q = RotationBetween(Vec3::UnitY(), Vec3::UnitZ());
  felt.Start({Vec3(0, 0, 20e-6), q});
  felt.state->cut.spins = false;
  const MeshOracle oracle = felt.Oracle();
  StepReport report;
  for (int n = 0; n < 300; ++n) {
    report = felt.Step({Vec3(1e-6 * n, 0, -0.5e-3), q});
    ASSERT_EQ(felt.state->cut.fields[0].changes(), 0u);
    ASSERT_FALSE(oracle.Meet(report.X_WG));
  }
  EXPECT_NEAR(report.wrench.force.z(), 0.5, 2e-3);
  felt.state->cut.spins = true;
  for (int n = 0; n < 300; ++n) report = felt.Step({Vec3(0.3e-3, 0, -0.5e-3), q});
  EXPECT_LT(report.X_WG.p.z(), -0.05e-3);
}

TEST(SolidContact, GoesOnAlikeFromACopyAndAsksForNoMemory) {
  Felt felt(Probe(), Block(kAskew));
  felt.Start(Hand::First());
  Hand hand(3);
  const Bur bur = Bur::Ball(0.3e-3);
  const auto step = [&](int n, StepState& state, const Pose& X) {
    const Vec3 at(-0.5e-3 + 2e-6 * n, 0, 0);
    state.cut.fields[0].Remove(bur, {kAskew.conjugate() * at, Quat::Identity()},
                               kAskew.conjugate() * Vec3(2e-6, 0, 0));
    return HapticStep(*felt.model, X, state, *felt.workspace);
  };
  const std::uint64_t before = test::AllocationsOfThisThread();
  for (int n = 0; n < 200; ++n) step(n, *felt.state, hand.Next());
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
  StepState copy = *felt.state;
  for (int n = 200; n < 400; ++n) {
    const Pose X = hand.Next();
    const StepReport one = step(n, *felt.state, X), other = step(n, copy, X);
    ASSERT_EQ(one.X_WG.p, other.X_WG.p) << n;
    ASSERT_EQ(one.wrench.force, other.wrench.force) << n;
  }
}

TEST(SolidContact, AStartInsideIsTakenOut) {
  Felt felt(Probe(), Block());
  felt.Groove(Bur::Ball(0.3e-3), Vec3(0.2e-3, 0, 0.3e-3), Vec3(0.2e-3, 0, -0.2e-3));
  const StartPose start =
      ResolveStart(*felt.model, At(0.2e-3, 0, -0.6e-3), *felt.workspace, felt.state->cut.fields);
  EXPECT_NEAR(start.depth, 0.1e-3, 0.05e-3);
  EXPECT_FALSE(felt.Oracle().Meet(start.X_WG));
  const StartPose buried = ResolveStart(*felt.model, At(0, 0, -3e-3), *felt.workspace);
  EXPECT_GT(buried.depth, 0.0);
}

}  // namespace
}  // namespace palpate
