#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "server/physics/haptic_model.h"
#include "server/physics/haptic_step.h"
#include "server/physics/limits.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/mesh_oracle.h"
#include "tests/support/optimised.h"
#include "tests/support/test_scenes.h"

namespace palpate {
namespace {

using test::MakeMeshBody;
using test::MeshOracle;

constexpr double kSeparation = 1e-6;
const double kRho = std::sqrt(limits::kTorsionalStiffness / limits::kStiffness);

Body Box(const char* name, const Vec3& size, const Vec3& at = Vec3::Zero()) {
  return MakeMeshBody(name, MakeBox(size), Pose{at, Quat::Identity()});
}

/// Tools that can touch each other and the objects, all in one frame.
class World {
 public:
  /// @param stiffness  k_t of each hand's spring [N/m]; empty: 1000
  /// @param mu         of friction between all; negative: none
  World(std::vector<Body> tools, std::vector<Body> objects, std::vector<double> stiffness = {},
        double mu = -1.0)
      : tools_(std::move(tools)), objects_(std::move(objects)) {
    const Material rough{.static_friction = mu, .dynamic_friction = mu};
    const std::vector<Material> materials(mu < 0.0 ? 0 : 1, rough);
    for (std::size_t i = 0; i < tools_.size(); ++i) {
      std::vector<PlacedTree> placed;
      for (const Body& object : objects_) {
        placed.push_back({.tree = &object.tree,
                          .X_WB = object.X_WB,
                          .mesh = &object.mesh,
                          .materials = materials});
      }
      for (std::size_t j = i + 1; j < tools_.size(); ++j) {
        placed.push_back({.tree = &tools_[j].tree,
                          .mesh = &tools_[j].mesh,
                          .materials = materials,
                          .frame = static_cast<std::int32_t>(j - i),
                          .tool = static_cast<std::int32_t>(j)});
      }
      StepParameters parameters;
      parameters.features.contact = ContactModel::kSurface;
      if (mu >= 0.0) parameters.features.friction = FrictionModel::kCoulomb;
      if (!stiffness.empty()) {
        parameters.stiffness = stiffness[i];
        parameters.torsional_stiffness = 1e-3 * stiffness[i];
      }
      // The last tool touches nothing of its own if there is no object: a body far away.
      if (placed.empty()) {
        placed.push_back({.tree = &tools_[i].tree,
                          .X_WB = {Vec3(9.0, 0.0, 0.0), Quat::Identity()},
                          .mesh = &tools_[i].mesh});
      }
      models_.push_back(std::make_unique<HapticModel>(
          tools_[i].tree, std::make_shared<const SceneObjects>(placed, ContactModel::kSurface),
          parameters, &tools_[i].mesh));
      states_.push_back(std::make_unique<StepState>(*models_[i]));
      workspaces_.push_back(std::make_unique<StepWorkspace>(*models_[i]));
      steps_.push_back({models_[i].get(), {}, states_[i].get(), workspaces_[i].get()});
    }
    std::vector<const HapticModel*> models;
    for (const auto& model : models_) models.push_back(model.get());
    together_ = std::make_unique<TogetherWorkspace>(models);
    MakeOracles();
  }

  void Put(std::size_t tool, const Pose& X_WG) { states_[tool]->X_WG = states_[tool]->X_WH = X_WG; }
  void Step(const std::vector<Pose>& hands) {
    for (std::size_t i = 0; i < steps_.size(); ++i) steps_[i].X_WH = hands[i];
    const std::uint64_t before = test::AllocationsOfThisThread();
    StepTogether(steps_, *together_);
    EXPECT_EQ(test::AllocationsOfThisThread(), before);
  }
  const StepReport& report(std::size_t tool) const { return steps_[tool].report; }
  const Vec3& force(std::size_t tool) const { return steps_[tool].report.wrench.force; }
  const Pose& X_WG(std::size_t tool) const { return states_[tool]->X_WG; }
  bool is_late() const { return (steps_[0].report.faults & kFaultTargetFar) != 0; }
  Vec3 reference_W(std::size_t tool) const { return X_WG(tool) * models_[tool]->reference(); }
  /// The torque of a tool's wrench about the world's origin [N m].
  Vec3 torque_W(std::size_t tool) const {
    return report(tool).wrench.torque + reference_W(tool).cross(force(tool));
  }
  /// Returns whether any tool meets another, or an object, by the exact oracle.
  bool Meet() const {
    for (const auto& [a, b, oracle] : oracles_) {
      if (oracle->Meet(b < 0 ? X_WG(a) : X_WG(std::size_t(b)).Inverse() * X_WG(a))) return true;
    }
    return false;
  }

 private:
  struct Pair {
    std::size_t a;
    int b;  ///< a tool, or negative: the objects
    std::unique_ptr<MeshOracle> oracle;
  };
  void MakeOracles() {
    for (std::size_t i = 0; i < tools_.size(); ++i) {
      Scene scene;
      scene.features.contact = ContactModel::kSurface;
      scene.tools = {tools_[i]};
      scene.objects = objects_;
      if (!objects_.empty()) oracles_.push_back({i, -1, std::make_unique<MeshOracle>(scene)});
      for (std::size_t j = i + 1; j < tools_.size(); ++j) {
        scene.objects = {tools_[j]};
        oracles_.push_back({i, static_cast<int>(j), std::make_unique<MeshOracle>(scene)});
      }
    }
  }

  std::vector<Body> tools_, objects_;
  std::vector<std::unique_ptr<HapticModel>> models_;
  std::vector<std::unique_ptr<StepState>> states_;
  std::vector<std::unique_ptr<StepWorkspace>> workspaces_;
  std::vector<ToolStep> steps_;
  std::unique_ptr<TogetherWorkspace> together_;
  std::vector<Pair> oracles_;
};

Pose At(double x, double y, double z) {
  return {Vec3(x, y, z), Quat::Identity()};
}

// Two springs in series: F = k_1 k_2 / (k_1 + k_2) d.
TEST(ToolsTogether, FeelEachOtherThroughBothSprings) {
  for (const double k : {1000.0, 300.0, 4000.0}) {
    World world({Box("a", Vec3(0.02, 0.02, 0.01)), Box("b", Vec3(0.03, 0.03, 0.01))}, {},
                {1000.0, k});
    world.Put(0, At(0.0, 0.0, 0.011));
    for (int i = 0; i < 600; ++i) {
      const double depth = 1e-5 * i - 0.002;  // of the hands' boxes in each other
      world.Step({At(0.0, 0.0, 0.01 - 0.5 * depth), At(0.0, 0.0, 0.5 * depth)});
      const double given = depth + kSeparation;
      const double force = given <= 0.0 ? 0.0 : 1000.0 * k / (1000.0 + k) * given;
      ASSERT_NEAR(world.force(0).z(), force, 1e-6 + 1e-3 * k * kSeparation) << i;
      ASSERT_LE((world.force(0) + world.force(1)).norm(), 1e-9 * force) << i;
      ASSERT_FALSE(world.Meet()) << i;
      ASSERT_EQ(world.report(0).faults | world.report(1).faults, 0u) << i;
    }
  }
}

// A hand that holds its tool fast is a wall to the other.
TEST(ToolsTogether, FeelAWallIfTheOtherSpringIsStiff) {
  World world({Box("a", Vec3(0.02, 0.02, 0.01)), Box("b", Vec3(0.03, 0.03, 0.01))}, {},
              {1000.0, 1e7});
  world.Put(0, At(0.0, 0.0, 0.02));
  for (int i = 0; i < 300; ++i) world.Step({At(0.0, 0.0, 0.01 - 1e-5 * i), At(0.0, 0.0, 0.0)});
  EXPECT_NEAR(world.force(0).z(), 1000.0 * 0.00299, 2e-3);
}

// One tool presses on another that lies on a floor: the floor bears both.
TEST(ToolsTogether, PressEachOtherOnTheFloor) {
  World world({Box("above", Vec3(0.02, 0.02, 0.01)), Box("below", Vec3(0.03, 0.03, 0.01))},
              {Box("floor", Vec3(0.1, 0.1, 0.01), Vec3(0.0, 0.0, -0.0101))});
  world.Put(0, At(0.0, 0.0, 0.02));
  for (int i = 0; i <= 300; ++i) {
    world.Step({At(0.0, 0.0, 0.012 - 1e-5 * i), At(0.0, 0.0, -5e-6 * i)});
    ASSERT_FALSE(world.Meet()) << i;
  }
  // The lower hand is 1.4 mm below where its tool rests, at -0.1 mm; the upper one 0.9 mm.
  EXPECT_NEAR(world.force(1).z(), 1.4, 3e-3);
  EXPECT_NEAR(world.force(0).z(), 0.9, 3e-3);
  EXPECT_FALSE(world.is_late());
}

/// A hand that swings through the place of the others, and turns.
Pose HandAt(int i, int hand) {
  const double t = 1e-3 * i + 0.7 * hand;
  const double side = hand % 2 == 0 ? 1.0 : -1.0;
  const Vec3 turn(0.3 * std::sin(3.0 * t), 0.4 * std::sin(2.0 * t), 0.5 * std::sin(4.0 * t));
  return {Vec3(0.006 * std::sin(5.0 * t) + (hand == 2 ? 0.012 : 0.0), 0.007 * std::sin(3.0 * t),
               side * (0.0035 + 0.004 * std::cos(4.0 * t))),
          RotationExp(side * turn)};
}

TEST(ToolsTogether, NeverEnterEachOtherAndBalance) {
  const Body box = Box("box", Vec3(0.013, 0.010, 0.011));
  const Body ball = MakeMeshBody("sphere", MakeSphere(0.006, 320));
  const Body small = Box("small", Vec3(0.008, 0.006, 0.007));
  struct Case {
    std::vector<Body> tools;
    std::vector<Body> objects;
    double mu = -1.0;
  };
  const Body floor = Box("floor", Vec3(0.06, 0.06, 0.01), Vec3(0.0, 0.0, -0.02));
  for (const Case& c : {Case{{box, small}, {}}, Case{{ball, box}, {}}, Case{{small, ball}, {floor}},
                        Case{{box, small, ball}, {floor}}, Case{{box, small}, {}, 0.3},
                        Case{{box, small, ball}, {floor}, 0.3}}) {
    World world(c.tools, c.objects, {}, c.mu);
    for (std::size_t j = 0; j < c.tools.size(); ++j) world.Put(j, At(0.05 * double(j), 0.0, 0.03));
    int late = 0, held = 0;
    const int steps = test::kOptimised ? 4000 : 400;
    for (int i = -400; i < steps; ++i) {
      std::vector<Pose> hands;
      for (int j = 0; j < int(c.tools.size()); ++j) {
        // From where the tools are apart.
        Pose hand = HandAt(std::max(i, 0), j);
        const double apart = i < 0 ? -i / 400.0 : 0.0;
        hand.p = (1.0 - apart) * hand.p + apart * Vec3(0.05 * j, 0.0, 0.03);
        hands.push_back(hand);
      }
      const Pose before[2] = {world.X_WG(0), world.X_WG(1)};
      world.Step(hands);
      ASSERT_FALSE(world.Meet()) << i;
      late += world.is_late() ? 1 : 0;
      held += world.force(0).norm() > 0.05 ? 1 : 0;
      ASSERT_EQ(world.report(0).faults & kFaultUnsolved, 0u) << i;
      if (!c.objects.empty() || world.is_late()) continue;
      const double force = world.force(0).norm();
      // With friction, what a turn moves the points that stick is made up for (Creep).
      const double most = c.mu > 0.0 ? 2e-6 : 1e-9;
      ASSERT_LE((world.force(0) + world.force(1)).norm(), most * (1.0 + force)) << i;
      // Rows are straight.  Where a step turns a tool by phi, half the product of phi and the
      // spring's torque is missing, and a force's arm is off by phi times its length, below 15 mm;
      // where it moves, by what changes a force by less than 1 mN, as a lone tool's.
      double error = 1e-9;
      for (std::size_t j = 0; j < 2; ++j) {
        error += before[j].q.angularDistance(world.X_WG(j).q) *
                     (0.5 * world.report(j).wrench.torque.norm() + 0.015 * force) +
                 std::min(1e-3 * kRho, force * (before[j].p - world.X_WG(j).p).norm());
      }
      ASSERT_LE((world.torque_W(0) + world.torque_W(1)).norm(), error) << i;
    }
    EXPECT_LT(late, steps / 50);
    EXPECT_GT(held, steps / 10);
  }
}

// Two springs in series here, too, up to Coulomb's limit.
TEST(ToolsTogether, StickAndSlipByCoulombsLaw) {
  World world({Box("a", Vec3(0.02, 0.02, 0.01)), Box("b", Vec3(0.03, 0.03, 0.01))}, {},
              {1000.0, 1000.0}, 0.3);
  world.Put(0, At(0.0, 0.0, 0.02));
  // 2 mm into each other: 1 N; then apart along x, by 10 um a cycle.
  for (int i = 0; i < 200; ++i) world.Step({At(0.0, 0.0, 0.0105 - 1.25e-5 * i), At(0.0, 0.0, 0.0)});
  int stuck = 0, slipped = 0;
  for (int i = 0; i < 150; ++i) {
    const double apart = 1e-5 * i;
    world.Step({At(apart, 0.0, 0.008), At(0.0, 0.0, 0.0)});
    const Vec3 force = world.force(0);
    ASSERT_NEAR(force.z(), 1.0, 3e-3) << i;
    ASSERT_LE((force + world.force(1)).norm(), 1e-9) << i;
    ASSERT_FALSE(world.Meet()) << i;
    // Both boxes tip by the moment of friction, by the same angle, so that they stay flush.
    const double give = 1.0 / limits::kStiffness + 0.005 * 0.005 / limits::kTorsionalStiffness;
    const double sticking = apart / (2.0 * give), limit = 0.3 * force.z();
    ASSERT_NEAR(-force.x(), std::min(sticking, limit), 3e-3) << i;
    stuck += sticking < limit ? 1 : 0;
    slipped += sticking > limit ? 1 : 0;
  }
  EXPECT_GT(stuck, 30);
  EXPECT_GT(slipped, 30);
}

// Who is the first of a pair does not count.
TEST(ToolsTogether, FeelTheSameIfTheyAreExchanged) {
  const Body box = Box("box", Vec3(0.013, 0.010, 0.011));
  const Body small = Box("small", Vec3(0.008, 0.006, 0.007));
  World one({box, small}, {}), other({small, box}, {});
  one.Put(1, At(0.05, 0.0, 0.0));
  other.Put(0, At(0.05, 0.0, 0.0));
  int compared = 0, off = 0, late = 0;
  for (int i = -400; i < 3000; ++i) {
    Pose a = HandAt(std::max(i, 0), 0), b = HandAt(std::max(i, 0), 1);
    if (i < 0) b.p += Vec3(-i / 400.0 * 0.05, 0.0, 0.0);
    one.Step({a, b});
    other.Step({b, a});
    late += one.is_late() || other.is_late() ? 1 : 0;
    if (one.is_late() || other.is_late() || one.force(0).norm() < 0.05) continue;
    ++compared;
    off += (one.force(0) - other.force(1)).norm() > 2e-3 ? 1 : 0;
  }
  EXPECT_GT(compared, 500) << late;
  // A box that slips off an edge may do so some cycles earlier.
  EXPECT_LT(off, compared / 100);
}

// Hands that stand still: what is left of the errors of straight rows goes.
TEST(ToolsTogether, BalanceToRoundingWhereTheyRest) {
  for (const double mu : {-1.0, 0.3}) {
    World world({Box("box", Vec3(0.013, 0.010, 0.011)), Box("small", Vec3(0.008, 0.006, 0.007))},
                {}, {}, mu);
    world.Put(1, At(0.05, 0.0, 0.0));
    for (int i = -400; i < 1600; ++i) {
      const int at = std::clamp(i, 0, 1250);
      Pose b = HandAt(at, 1);
      b.p.x() += std::max(0, -i) / 400.0 * 0.05;
      world.Step({HandAt(at, 0), b});
    }
    const double force = world.force(0).norm(), torque = world.torque_W(0).norm();
    EXPECT_GT(force, 1.0);
    EXPECT_FALSE(world.is_late());
    EXPECT_LE((world.force(0) + world.force(1)).norm(), 1e-9 * force);
    EXPECT_LE((world.torque_W(0) + world.torque_W(1)).norm(), 1e-9 * (torque + kRho * force));
    // The contacts of both reports are the same ones, and give both wrenches.
    EXPECT_EQ(world.report(0).contacts, world.report(1).contacts);
    for (std::size_t j = 0; j < 2; ++j) {
      Wrench sum;
      for (int k = 0; k < world.report(j).contacts; ++k) {
        const ActiveRow& row = world.report(j).active[std::size_t(k)];
        EXPECT_EQ(row.tool, j == 0 ? 1 : 0);
        sum.force += row.force * row.normal + row.friction;
        sum.torque += row.force * row.lever_cross_normal +
                      (row.contact_W - world.reference_W(j)).cross(row.friction);
      }
      EXPECT_LE((sum.force - world.force(j)).norm(), 1e-6 * force);
      EXPECT_LE((sum.torque - world.report(j).wrench.torque).norm(),
                1e-5 * (torque + force * kRho));
    }
  }
}

TEST(ToolsTogether, AreRefusedInWordsIfTheyCannotBe) {
  const Body box = Box("box", Vec3(0.013, 0.010, 0.011));
  const auto said = [](const std::vector<Body>& tools) -> std::string {
    try {
      World(tools, {});
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(said({box, box}), "");
  EXPECT_EQ(said({test::BallBody(0.004), box}), "");
  EXPECT_THAT(said({box, test::BallBody(0.004)}), testing::HasSubstr("and not the second"));
  EXPECT_THAT(said({box}), testing::HasSubstr("two to eight"));
  EXPECT_THAT(said(std::vector<Body>(9, box)), testing::HasSubstr("two to eight"));
}

TEST(ToolsTogether, GoOnWithoutAToolWhosePoseIsNotUsable) {
  World world({Box("a", Vec3(0.02, 0.02, 0.01)), Box("b", Vec3(0.03, 0.03, 0.01))}, {});
  world.Put(0, At(0.0, 0.0, 0.02));
  for (int i = 0; i < 300; ++i) world.Step({At(0.0, 0.0, 0.0105 - 1e-5 * i), At(0.0, 0.0, 0.0)});
  const Vec3 before = world.force(0);
  Pose bad;
  bad.p.x() = std::numeric_limits<double>::quiet_NaN();
  world.Step({At(0.0, 0.0, 0.00751), bad});
  EXPECT_NE(world.report(1).faults & kFaultBadPose, 0u);
  EXPECT_EQ(world.force(1).norm(), 0.0);
  EXPECT_EQ(world.report(0).faults, 0u);
  EXPECT_NEAR(world.force(0).z(), before.z(), 1e-6);
}

}  // namespace
}  // namespace palpate
