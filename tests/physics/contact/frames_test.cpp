#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "server/physics/haptic_model.h"
#include "server/physics/haptic_step.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/mesh_oracle.h"
#include "tests/support/optimised.h"
#include "tests/support/test_scenes.h"

namespace palpate {
namespace {

using test::BallBody;
using test::MakeMeshBody;
using test::MeshOracle;

/// A box over a floor, between two walls that lean towards it: every contact of it is with several
/// bodies at once.
Scene BoxInAGroove() {
  Scene scene;
  scene.tools.push_back(MakeMeshBody("box", MakeBox(Vec3(0.013, 0.010, 0.011))));
  const auto wall = [](double side) {
    return Pose{Vec3(0.02 * side, 0.0, 0.0), Quat(Eigen::AngleAxisd(0.2 * side, Vec3::UnitY()))};
  };
  scene.objects.push_back(MakeMeshBody("floor", MakeBox(Vec3(0.06, 0.06, 0.01)),
                                       Pose{Vec3(0.0, 0.0, -0.015), Quat::Identity()}));
  scene.objects.push_back(MakeMeshBody("left", MakeBox(Vec3(0.01, 0.05, 0.03)), wall(-1.0)));
  scene.objects.push_back(MakeMeshBody("right", MakeBox(Vec3(0.01, 0.05, 0.03)), wall(1.0)));
  for (Body& object : scene.objects) {
    object.materials.resize(1);
    object.materials[0].static_friction = 0.3;
    object.materials[0].dynamic_friction = 0.3;
  }
  scene.features.contact = ContactModel::kSurface;
  return scene;
}

/// The model of a scene whose objects have these frames.
HapticModel ModelOf(const Scene& scene, std::array<int, 3> frame, FrictionModel friction) {
  std::vector<PlacedTree> placed;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const Body& object = scene.objects[i];
    placed.push_back({.tree = &object.tree,
                      .X_WB = object.X_WB,
                      .mesh = &object.mesh,
                      .leaf_material = object.leaf_material,
                      .materials = object.materials,
                      .frame = frame[i]});
  }
  StepParameters parameters;
  parameters.features = scene.features;
  parameters.features.friction = friction;
  const Body& tool = scene.tools.front();
  return HapticModel(tool.tree,
                     std::make_shared<const SceneObjects>(placed, ContactModel::kSurface),
                     parameters, &tool.mesh);
}

/// A hand that swings between the walls and into the floor, and turns.
Pose HandAt(int i) {
  const double t = 1e-3 * i;
  const Vec3 turn(0.3 * std::sin(7.0 * t), 0.2 * std::sin(5.0 * t), 0.5 * std::sin(3.0 * t));
  return {Vec3(0.012 * std::sin(9.0 * t), 0.01 * std::sin(4.0 * t), 0.004 * std::cos(6.0 * t)),
          RotationExp(turn)};
}

// Bodies that stand still to each other are one frame; were each a frame of its own, with a front
// of its own, nothing could be felt of it.
TEST(Frames, GiveTheForcesOfOneFrameIfTheyStandStill) {
  const Scene scene = BoxInAGroove();
  for (const FrictionModel friction : {FrictionModel::kOff, FrictionModel::kCoulomb}) {
    const HapticModel one = ModelOf(scene, {0, 0, 0}, friction);
    const HapticModel three = ModelOf(scene, {0, 1, 2}, friction);
    StepWorkspace workspace_of_one(one), workspace_of_three(three);
    StepState state_of_one(one), state_of_three(three);
    ASSERT_EQ(state_of_three.frames.size(), 3u);
    MeshOracle oracle(scene);
    int held = 0, by_several = 0;
    for (int i = 0; i < 2500; ++i) {
      const StepReport a = HapticStep(one, HandAt(i), state_of_one, workspace_of_one);
      const StepReport b = HapticStep(three, HandAt(i), state_of_three, workspace_of_three);
      ASSERT_FALSE(oracle.Meet(state_of_three.X_WG)) << i;
      if (((a.faults | b.faults) & kFaultTargetFar) != 0) continue;
      // As far apart as two answers may be that both keep delta: 1 um, which is 1 mN.
      ASSERT_LT((a.wrench.force - b.wrench.force).norm(), 2e-3) << i;
      held += b.contacts > 0 ? 1 : 0;
      for (int k = 1; k < b.contacts; ++k) {
        by_several += b.active[std::size_t(k)].id.body != b.active[0].id.body ? 1 : 0;
      }
    }
    EXPECT_GT(held, 500);
    EXPECT_GT(by_several, 50);
  }
}

/// Where a body that swings and turns is.
Pose BodyAt(int i) {
  const double t = 1e-3 * i;
  return {
      Vec3(0.01 * std::sin(5.0 * t), 0.008 * std::sin(3.0 * t), 0.006 * std::sin(8.0 * t)),
      RotationExp(Vec3(0.2 * std::sin(4.0 * t), 0.3 * std::sin(2.0 * t), 0.1 * std::sin(6.0 * t)))};
}

/// A scene with a ball in place of the box, and a body of curved faces and creases on the floor.
Scene BallOnABump() {
  Scene scene = BoxInAGroove();
  scene.tools[0] = BallBody(0.004);
  const std::vector<Material> materials = scene.objects[0].materials;
  scene.objects[0] =
      MakeMeshBody("bump", MakeSphere(0.02, 1280), Pose{Vec3(0.0, 0.0, -0.024), Quat::Identity()});
  scene.objects[0].materials = materials;
  return scene;
}

/// What a hand at X_WH feels of bodies that are at X_WB next, in their frame.
struct Felt {
  Pose X_BG;
  Vec3 force_B, torque_B;
  std::uint32_t faults;
};
Felt StepIn(const HapticModel& model, const Pose& X_WB, const Pose& X_BH, StepState& state,
            StepWorkspace& workspace) {
  for (std::size_t i = 1; i < state.frames.size(); ++i) state.frames[i].X_WB_next = X_WB;
  const StepReport report = HapticStep(model, X_WB * X_BH, state, workspace);
  const Pose X_BW = X_WB.Inverse();
  return {X_BW * state.X_WG, X_BW.q * report.wrench.force, X_BW.q * report.wrench.torque,
          report.faults};
}

// Contact knows no velocity: a hand feels of bodies that all move together what it feels of the
// same bodies at rest, if it moves against them in the same way.
TEST(Frames, FeelAsTheSameBodiesAtRestIfAllMoveTogether) {
  for (const Scene& scene : {BoxInAGroove(), BallOnABump()}) {
    for (const FrictionModel friction : {FrictionModel::kOff, FrictionModel::kCoulomb}) {
      const HapticModel rest = ModelOf(scene, {0, 0, 0}, friction);
      const HapticModel moves = ModelOf(scene, {1, 1, 1}, friction);
      StepWorkspace workspace_of_rest(rest), workspace_of_moves(moves);
      StepState state_of_rest(rest), state_of_moves(moves);
      MeshOracle oracle(scene);
      // 1 um, the separation, is 1 mN.  A ball on facets rests within 8 mN of where it would if its
      // hand trembled by 1 um; wedged with friction it may slip a cycle earlier.  Its own rotation
      // gives no slip, but a body's does.
      const bool has_friction = friction == FrictionModel::kCoulomb;
      const double most = rest.is_ball() ? 0.01 : 2e-3;
      const bool turns = !rest.is_ball() || !has_friction;
      int held = 0, late = 0, off = 0;
      for (int i = 0; i < 2500; ++i) {
        const Felt a = StepIn(rest, {}, HandAt(i), state_of_rest, workspace_of_rest);
        const Pose X_WB = turns ? BodyAt(i) : Pose{BodyAt(i).p, Quat::Identity()};
        const Felt b = StepIn(moves, X_WB, HandAt(i), state_of_moves, workspace_of_moves);
        ASSERT_FALSE(oracle.Meet(b.X_BG)) << i;
        const bool is_late = ((a.faults | b.faults) & kFaultTargetFar) != 0;
        late += is_late ? 1 : 0;
        if (is_late) continue;
        off += (a.force_B - b.force_B).norm() > most ? 1 : 0;
        off += (a.torque_B - b.torque_B).norm() > 2e-4 ? 1 : 0;
        held += a.force_B.norm() > 0.01 ? 1 : 0;
      }
      EXPECT_GT(held, 500);
      EXPECT_LT(late, 25);
      EXPECT_LE(off, rest.is_ball() && has_friction ? 5 : 0);
    }
  }
}

// Each body swings in its own way, and they squeeze the tool between them: none is entered, and
// all go on as far as the tool can give way.
TEST(Frames, AreNeverEnteredHoweverTheyMove) {
  const Scene scene = BoxInAGroove();
  std::vector<Scene> alone(3, scene);
  std::vector<std::unique_ptr<MeshOracle>> oracles;
  for (std::size_t i = 0; i < 3; ++i) {
    alone[i].objects = {scene.objects[i]};
    oracles.push_back(std::make_unique<MeshOracle>(alone[i]));
  }
  for (const FrictionModel friction : {FrictionModel::kOff, FrictionModel::kCoulomb}) {
    const HapticModel model = ModelOf(scene, {1, 2, 3}, friction);
    StepWorkspace workspace(model);
    StepState state(model);
    int late = 0, stopped = 0;
    for (int i = 0; i < (test::kOptimised ? 4000 : 400); ++i) {
      for (int frame = 1; frame <= 3; ++frame) {
        state.frames[std::size_t(frame)].X_WB_next =
            BodyAt(i == 0 ? 0 : i * frame + 700 * (frame - 1));
      }
      const std::uint64_t before = test::AllocationsOfThisThread();
      const StepReport report = HapticStep(model, HandAt(i), state, workspace);
      ASSERT_EQ(test::AllocationsOfThisThread(), before) << i;
      late += (report.faults & kFaultTargetFar) != 0 ? 1 : 0;
      for (std::size_t frame = 1; frame <= 3; ++frame) {
        const BodyFrame& of = state.frames[frame];
        stopped += (of.X_WB.p - of.X_WB_next.p).norm() > 1e-9 ? 1 : 0;
        ASSERT_FALSE(oracles[frame - 1]->Meet(of.X_WB.Inverse() * state.X_WG)) << i << frame;
      }
    }
    EXPECT_LT(late, 400);
    if (test::kOptimised) EXPECT_GT(stopped, 50);
  }
}

// A plate that comes up under a hand that stands still, and goes down again: nothing is felt of
// where it was, even where a hand that jumps lags behind.
TEST(Frames, PushAToolThatIsInTheirWay) {
  Scene scene = BoxInAGroove();
  for (const FrictionModel friction : {FrictionModel::kOff, FrictionModel::kCoulomb}) {
    const HapticModel model = ModelOf(scene, {1, 0, 0}, friction);
    StepWorkspace workspace(model);
    StepState state(model);
    const double floor = -0.010, half = 0.0055;
    for (int i = 0; i <= 900; ++i) {
      const double up = 1e-5 * (300 - std::abs(i % 600 - 300)) * 3.0;
      const double hand = i > 600 ? -0.0001 * (i % 2) : 0.0;
      state.frames[1].X_WB_next.p.z() = up;
      const StepReport report =
          HapticStep(model, {Vec3(0.0, 0.0, hand), Quat::Identity()}, state, workspace);
      const double depth = floor + up + half - hand;
      EXPECT_EQ(state.frames[1].X_WB.p.z(), up) << i;
      EXPECT_NEAR(report.wrench.force.z(), 1000.0 * std::max(0.0, depth), 2e-3) << i;
      EXPECT_NEAR(report.wrench.force.head<2>().norm(), 0.0, 2e-3) << i;
    }
  }
}

// What is squeezed between a body that moves and one that stands stops the former.
TEST(Frames, StopWhereAToolCannotGiveWay) {
  Scene scene = BoxInAGroove();
  scene.objects[1] = MakeMeshBody("lid", MakeBox(Vec3(0.06, 0.06, 0.01)),
                                  Pose{Vec3(0.0, 0.0, 0.012), Quat::Identity()});
  const HapticModel model = ModelOf(scene, {1, 0, 0}, FrictionModel::kOff);
  StepWorkspace workspace(model);
  StepState state(model);
  StepReport report;
  for (int i = 0; i <= 400; ++i) {
    state.frames[1].X_WB_next.p.z() = 3e-5 * i;
    report = HapticStep(model, Pose{}, state, workspace);
  }
  // From -0.010 to the box's height below the lid at 0.007.
  EXPECT_NEAR(state.frames[1].X_WB.p.z(), 0.006, 1e-5);
  EXPECT_NEAR(state.X_WG.p.z(), 0.0015, 1e-5);
  EXPECT_NE(report.faults & kFaultTargetFar, 0u);
  state.frames[1].X_WB_next.p.z() = 0.0;
  for (int i = 0; i < 50; ++i) report = HapticStep(model, Pose{}, state, workspace);
  EXPECT_EQ(state.frames[1].X_WB.p.z(), 0.0);
  EXPECT_EQ(report.wrench.force.norm(), 0.0);
}

// A scene's own groups move by the number of steps, from where they are placed when the tool
// starts.
TEST(Frames, OfASceneMoveStepByStep) {
  Scene scene = BoxInAGroove();
  MovedGroup& lift = scene.moved.emplace_back();
  lift.name = "lift";
  lift.keys = {{}, {300, 0.0, {0.0, 0.0, 0.009}}, {600, 0.0, Vec3::Zero()}};
  lift.repeats = true;
  scene.objects[0].moved = 1;
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  StepWorkspace workspace(model);
  const StartPose start = ResolveStart(model, Pose{}, workspace);
  EXPECT_EQ(start.depth, 0.0);
  // In the floor where it begins: the way out does not wait for it to sink.
  const StartPose out = ResolveStart(model, {Vec3(0.0, 0.0, -0.012), Quat::Identity()}, workspace);
  EXPECT_NEAR(out.X_WG.p.z(), -0.0045, 2e-5);
  StepState state(model);
  const double floor = -0.010, half = 0.0055;
  for (int i = 1; i <= 1500; ++i) {
    const StepReport report = HapticStep(model, Pose{}, state, workspace);
    const double up = lift.At(i).p.z();
    EXPECT_EQ(state.frames[1].X_WB.p.z(), up) << i;
    EXPECT_NEAR(report.wrench.force.z(), 1000.0 * std::max(0.0, floor + up + half), 2e-3) << i;
  }
  state.RestMoved(state.frames.size());
  EXPECT_EQ(state.frames[1].X_WB.p.z(), 0.0);
  EXPECT_EQ(HapticStep(model, Pose{}, state, workspace).wrench.force.norm(), 0.0);
}

TEST(Frames, StayWhereTheyAreIfTheirNextPoseIsNotUsable) {
  const HapticModel model = ModelOf(BoxInAGroove(), {1, 0, 0}, FrictionModel::kCoulomb);
  StepWorkspace workspace(model);
  StepState state(model);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    state.frames[1].X_WB_next.p.x() = bad;
    const StepReport report = HapticStep(model, Pose{}, state, workspace);
    EXPECT_NE(report.faults & kFaultBadPose, 0u);
    EXPECT_EQ(state.frames[1].X_WB.p, Vec3(Vec3::Zero()));
    EXPECT_TRUE(state.X_WG.p.allFinite());
  }
  state.frames[1].X_WB_next.p = Vec3(0.0, 0.0, 1e-4);
  EXPECT_EQ(HapticStep(model, Pose{}, state, workspace).faults, kFaultNone);
  EXPECT_EQ(state.frames[1].X_WB.p.z(), 1e-4);
}

// A belt that runs under a hand that presses on it drags the hand along with mu_d.
TEST(Frames, DragWithTheForceOfFriction) {
  Scene scene = BoxInAGroove();
  const HapticModel model = ModelOf(scene, {1, 0, 0}, FrictionModel::kCoulomb);
  StepWorkspace workspace(model);
  StepState state(model);
  StepReport report;
  for (int i = 0; i <= 400; ++i) {
    const Pose X_WH{Vec3(0.0, 0.0, std::max(-0.007, -3e-5 * i)), Quat::Identity()};
    state.frames[1].X_WB_next.p.y() = 2e-5 * std::max(0, i - 300);
    report = HapticStep(model, X_WH, state, workspace);
  }
  ASSERT_NEAR(report.wrench.force.z(), 2.5, 3e-3);
  EXPECT_NEAR(report.wrench.force.y(), 0.3 * report.wrench.force.z(), 0.01);
  EXPECT_NEAR(report.wrench.force.x(), 0.0, 3e-3);
}

}  // namespace
}  // namespace palpate
