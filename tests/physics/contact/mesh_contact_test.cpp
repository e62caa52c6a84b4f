#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "server/physics/contact/sub_step.h"
#include "server/physics/haptic_step.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "tests/physics/contact/contact_scenes.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/mesh_oracle.h"
#include "tests/support/optimised.h"
#include "tests/support/random.h"
#include "tests/support/test_scenes.h"

namespace palpate {
namespace {

using test::BallBody;
using test::MakeMeshBody;
using test::MeshOracle;
using test::Random;

Scene MakeScene(Body tool, Body object) {
  Scene scene;
  scene.tools.push_back(std::move(tool));
  scene.objects.push_back(std::move(object));
  return scene;
}

Quat Turn(double degrees, const Vec3& axis) {
  return Quat(Eigen::AngleAxisd(degrees * M_PI / 180, axis));
}

Body Box(const Vec3& size, const Pose& X = {}) {
  return MakeMeshBody("box", MakeBox(size), X);
}

/// A scene's first tool with its state, and the oracle that checks its pose.
struct Touch {
  Touch(Scene s, const Pose& start)
      : scene(std::move(s)),
        model(MakeModel(scene, scene.tools.front(), MakeObjects(scene))),
        workspace(model),
        state(model),
        oracle(scene) {
    state.X_WG = state.X_WH = start;
  }
  Touch(Scene s, const Vec3& start) : Touch(std::move(s), Pose{start, Quat::Identity()}) {}
  /// Expects the meshes to be apart after the step.
  StepReport Step(const Pose& X_WH) {
    const StepReport report = HapticStep(model, X_WH, state, workspace);
    ++steps;
    far += (report.faults & kFaultTargetFar) != 0;
    EXPECT_FALSE(oracle.Meet(state.X_WG)) << "the meshes meet after step " << steps;
    return report;
  }
  /// Moves the hand in a straight line to a pose, and holds it there until the tool is at rest.
  StepReport Go(const Pose& X_WH, int moving, int resting = 30) {
    const Pose from = state.X_WH;
    const Vec3 turn = RotationLog(X_WH.q * from.q.conjugate());
    StepReport report;
    for (int i = 1; i <= moving + resting; ++i) {
      const double s = std::min(1.0, static_cast<double>(i) / moving);
      report = Step({(1.0 - s) * from.p + s * X_WH.p, RotationExp(s * turn) * from.q});
    }
    return report;
  }

  Scene scene;
  HapticModel model;
  StepWorkspace workspace;
  StepState state;
  MeshOracle oracle;
  int steps = 0, far = 0;  ///< steps taken, and those in which the tool did not arrive
};

// A ball among the leaves of a sparse tree: the mesh stops it from every direction.
TEST(MeshContact, HasNoGapThroughWhichABallCanFall) {
  Touch touch(MakeScene(BallBody(0.001), Box(Vec3::Constant(0.05))), Vec3(0.0, 0.0, 0.05));
  Random random(3);
  for (int candidate = 0; candidate < 40; ++candidate) {
    const Vec3 from = 0.06 * random.Direction();
    touch.state = StepState(touch.model);
    touch.state.X_WG.p = touch.state.X_WH.p = from;
    for (int i = 1; i <= 300; ++i) {
      // To the cube's centre at 0.2 m/s.
      touch.Step({from * (1.0 - i / 300.0), Quat::Identity()});
      const Vec3 out = (touch.state.X_WG.p.cwiseAbs().array() - 0.025).matrix().cwiseMax(0.0);
      ASSERT_GE(out.norm(), 0.001) << "candidate " << candidate << ", step " << i;
    }
  }
}

TEST(MeshContact, GivesTheAnalyticForceOfABallOnAFlatFace) {
  Touch touch(MakeScene(BallBody(0.005), Box(Vec3::Constant(0.05))), Vec3(-0.015, 0.0301, 0.0));
  for (int i = 0; i < 600; ++i) {
    const StepReport report = touch.Step({Vec3(-0.015 + 5e-5 * i, 0.029, 0.003), Quat::Identity()});
    if (i < 2) continue;
    // At most 1 um apart, which is 1 mN.
    EXPECT_NEAR(report.wrench.force.y(), 1.0, 1.01e-3);
    EXPECT_NEAR(report.wrench.force.x(), 0.0, 1e-6);
    EXPECT_NEAR(report.wrench.force.z(), 0.0, 1e-6);
  }
}

TEST(MeshContact, RestsABoxFlatOnAPlaneWithoutTorque) {
  Touch touch(MakeScene(Box(Vec3(0.02, 0.01, 0.02)), Box(Vec3(0.1, 0.02, 0.1))),
              Vec3(0.0, 0.016, 0.0));
  for (int i = 0; i < 500; ++i) {
    const StepReport report = touch.Step({Vec3(4e-5 * i, 0.014, 2e-5 * i), Quat::Identity()});
    if (i < 20) continue;
    EXPECT_NEAR(report.wrench.force.y(), 1.0, 2e-3);
    EXPECT_LT(report.wrench.torque.norm(), 1e-5);
    EXPECT_LT(RotationLog(report.X_WG.q).norm(), 1e-5);
  }
}

TEST(MeshContact, KeepsTheSeparationThatASceneAsksFor) {
  for (const double separation : {1e-8, 1e-6, 1e-4}) {
    Scene scene = MakeScene(Box(Vec3(0.02, 0.01, 0.02)), Box(Vec3(0.1, 0.02, 0.1)));
    scene.tuning.separation = separation;
    Touch touch(std::move(scene), Vec3(0.0, 0.0152, 0.0));
    const StepReport report = touch.Go({Vec3(0.0, 0.014, 0.0), Quat::Identity()}, 20);
    // 1 mm deep at 1 N/mm.  A pair may have lost half of delta when it is found.
    EXPECT_GE(report.wrench.force.y(), 1.0 + 0.5e3 * separation - 2e-6);
    EXPECT_LE(report.wrench.force.y(), 1.0 + 1e3 * separation + 2e-6);
    EXPECT_EQ(report.faults & kFaultTargetFar, 0u);
  }
}

TEST(MeshContact, LeadsABallOverAFlushSeamOfTwoBodies) {
  Scene scene = MakeScene(BallBody(0.003),
                          Box(Vec3::Constant(0.02), {Vec3(-0.01, 0.0, 0.0), Quat::Identity()}));
  scene.objects.push_back(Box(Vec3::Constant(0.02), {Vec3(0.01, 0.0, 0.0), Quat::Identity()}));
  for (const double stride : {1e-6, 1e-5, 5e-5, 2e-4}) {
    Touch touch(scene, Vec3(-0.0003, 0.0135, 0.0013));
    touch.Go({Vec3(-0.0003, 0.012, 0.0013), Quat::Identity()}, 20);
    for (double x = -0.0003; x < 0.0003; x += stride) {
      const Vec3 force = touch.Step({Vec3(x, 0.012, 0.0013), Quat::Identity()}).wrench.force;
      EXPECT_LE(std::hypot(force.x(), force.z()), 0.0008) << x << ", by " << stride;
      EXPECT_NEAR(force.y(), 1.001, 1e-4);
    }
  }
}

TEST(MeshContact, RubsAsCoulombSays) {
  Scene scene = MakeScene(Box(Vec3::Constant(0.01)), Box(Vec3(0.2, 0.06, 0.06)));
  scene.features.friction = FrictionModel::kCoulomb;
  scene.objects[0].materials = {Material{.static_friction = 0.8, .dynamic_friction = 0.3}};
  Touch touch(std::move(scene), Vec3(-0.05, 0.0, 0.035001));
  // 1 N down and 0.6 N sideways: less than 0.8 N holds indefinitely.
  const Vec3 pressed(-0.05, 0.0, 0.034);
  StepReport report;
  for (int i = 0; i < 50; ++i) report = touch.Step({pressed, Quat::Identity()});
  const Vec3 stuck = report.X_WG.p;
  for (int i = 0; i < 500; ++i) {
    const double along = 0.6e-3 * std::min(1.0, 0.01 * i);
    report = touch.Step({pressed + Vec3(along, 0, 0), Quat::Identity()});
  }
  EXPECT_NEAR(report.wrench.force.x(), -0.6, 1e-5);
  EXPECT_NEAR((report.X_WG.p - stuck).norm(), 0.0, 1e-8);
  // Drawn along at 0.1 m/s it slides, with mu_d times the normal force.
  for (int i = 0; i < 600; ++i) {
    report = touch.Step({pressed + Vec3(0.6e-3 + 1e-4 * i, 0, 0), Quat::Identity()});
    if (i < 100) continue;
    const Vec3& f = report.wrench.force;
    EXPECT_NEAR(-f.x() / f.z(), 0.3, 0.003) << i;
    EXPECT_NEAR(f.z(), 1.0, 0.01);
    // Where it crosses an inner edge the contact changes: the force changes by less than 3 mN.
    EXPECT_NEAR(f.y(), 0.0, 3e-3);
  }
}

/// Expects the spring's force for a hand `depth` below the tool along `normal`, and no other.
void ExpectForce(const StepReport& report, const Vec3& normal, double depth, double error = 2e-3) {
  const double along = normal.dot(report.wrench.force);
  EXPECT_LE((report.wrench.force - along * normal).norm(), 0.01);
  EXPECT_NEAR(along, 1000.0 * depth, error);
}

/// Presses with 3 N on a flat surface, at rest and across inner edges, turned about the normal.
void PressAndSlide(const TriangleMesh& floor, double error = 2e-3, int most_far = 0) {
  for (const double degrees : {0.0, 1.0, 23.0, 45.0}) {
    SCOPED_TRACE(testing::Message() << degrees << " degrees");
    const Quat q = Turn(degrees, Vec3::UnitZ());
    Touch touch(MakeScene(Box(Vec3(0.02, 0.02, 0.01)), MakeMeshBody("floor", floor)),
                Pose{Vec3(-0.0113, -0.0071, 0.0055), q});
    ExpectForce(touch.Go({Vec3(-0.0113, -0.0071, 0.002), q}, 40), Vec3::UnitZ(), 0.003);
    for (int i = 1; i <= 300; ++i) {
      ExpectForce(touch.Step({Vec3(-0.0113 + 8e-5 * i, -0.0071 + 5e-5 * i, 0.002), q}),
                  Vec3::UnitZ(), 0.003, error);
    }
    EXPECT_LT(RotationLog(touch.state.X_WG.q * q.conjugate()).norm(), 2e-4);
    EXPECT_LE(touch.far, most_far);
  }
}

TEST(MeshContact, GivesNoGhostForceOnAFlatFace) {
  TriangleMesh floor = MakeBox(Vec3(0.1, 0.1, 0.02));
  for (Vec3& v : floor.vertices) v.z() -= 0.01;
  PressAndSlide(floor);
}

TEST(MeshContact, GivesNoGhostForceOnAFlatGrid) {
  // Once in 1,200 steps a corner that crosses an inner edge tilts the tool by 1.5 um.
  PressAndSlide(test::MakeBlock(16, 0.05, 0.02, test::Flat), 3e-3);
}

TEST(MeshContact, GivesNoGhostForceOverNeedles) {
  // In a few steps the tool does not arrive, or stops a few micrometres short.
  PressAndSlide(test::MakeBlock(test::kCrowded, 0.05, 0.02, test::Flat, test::Crowded), 0.02, 2);
}

TEST(MeshContact, GivesNoGhostForceOfAFacetedBallOnAFlatGrid) {
  Random random(61);
  for (int candidate = 0; candidate < (test::kOptimised ? 12 : 3); ++candidate) {
    SCOPED_TRACE(testing::Message() << "candidate " << candidate);
    const Quat q = random.Rotation();
    const Vec3 over(random.Uniform(-0.01, 0.01), random.Uniform(-0.01, 0.01), 0.0155);
    Touch touch(MakeScene(MakeMeshBody("ball", MakeSphere(0.015, 320)),
                          MakeMeshBody("floor", test::MakeBlock(16, 0.05, 0.02, test::Flat))),
                Pose{over, q});
    touch.Go({over - Vec3(0, 0, 0.0035), q}, 40);
    for (int i = 1; i <= 100; ++i) {
      const StepReport report = touch.Step({over + Vec3(1e-4 * i, 3e-5 * i, -0.0035), q});
      EXPECT_LE(report.wrench.force.head<2>().norm(), 0.01);
      EXPECT_GT(report.wrench.force.z(), 2.8);
    }
  }
}

TEST(MeshContact, LetsABallFeelTheSphereThatAMeshStandsFor) {
  // With 320 triangles, facet normals deviate by up to 8 degrees from the sphere's.
  const double outer = 0.03, radius = 0.005;
  Touch touch(MakeScene(BallBody(radius), MakeMeshBody("sphere", MakeSphere(outer, 320))),
              Vec3(0.0, 0.0, outer + radius + 1e-3));
  double worst = 0.0;
  for (int i = 0; i <= 500; ++i) {
    const double down = std::min(2e-3, 4e-5 * i), angle = 2e-3 * i;
    const Vec3 out(std::sin(angle), 0.2 * std::sin(2.0 * angle), std::cos(angle));
    const StepReport report =
        touch.Step({(outer + radius + 1e-3 - down) * out.normalized(), Quat::Identity()});
    if (i < 100) continue;
    const Vec3 force = report.wrench.force;
    worst = std::max(worst, force.cross(touch.state.X_WG.p.normalized()).norm() / force.norm());
  }
  EXPECT_LT(worst, 0.03);
}

TEST(MeshContact, LetsABallComeSlowlyOverFacets) {
  // Its rows follow the smooth sphere, which leads over the facets' edges and so slightly away from
  // the hand: no reason to stop.
  const double outer = 0.03, radius = 0.005;
  Touch touch(MakeScene(BallBody(radius), MakeMeshBody("sphere", MakeSphere(outer, 1280))),
              Vec3(0.0, 0.0, outer + radius + 1e-3));
  for (int i = 0; i <= 4000; ++i) {
    const double depth = std::min(3e-3, 1e-5 * i), angle = 6e-4 * i;
    const Vec3 out(std::sin(angle), 0.3 * std::sin(0.7 * angle), std::cos(angle));
    touch.Step({(outer + radius - depth) * out.normalized(), Quat::Identity()});
  }
  EXPECT_EQ(touch.far, 0);
}

// The position of a ball pressed into a cube's rounded offset surface follows from the cube's
// nearest point, without linearisation.  Past an edge it moves up to ten times as fast as the hand.
TEST(MeshContact, LetsABallGoRoundEdgesAndCornersWithTheAnalyticForce) {
  const double half = 0.025, radius = 0.005;
  const Vec3 corner = Vec3::Constant(half);
  const auto nearest = [&](const Vec3& p) { return Vec3(p.cwiseMax(-half).cwiseMin(half)); };
  for (std::uint64_t seed = 1; seed <= (test::kOptimised ? 20 : 4); ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    Vec3 hand = corner + 0.0051 * Vec3(0.1, 0.2, 1.0).normalized();
    Touch touch(MakeScene(BallBody(radius), Box(Vec3::Constant(2.0 * half))), hand);
    Vec3 way = Vec3::Zero();
    double turned = 0.0;
    Vec3 last = Vec3::UnitZ();
    for (int i = 0; i < 3000; ++i) {
      // At 0.3 m/s; turns before it would leave the corner, enter the cube or be free of it.
      Vec3 to = hand + way;
      const auto leaves = [&] {
        const double out = (to - nearest(to)).norm();
        return !(out > 0.5e-3 && out < 4.9e-3 && (to - corner).norm() < 0.008);
      };
      for (int tries = 0; leaves() && tries < 1000; ++tries) {
        way = 3e-4 * random.Direction();
        to = hand + way;
      }
      hand = to;
      const StepReport report = touch.Step({hand, Quat::Identity()});
      if ((report.faults & kFaultTargetFar) != 0) continue;
      const double outside = (hand - nearest(hand)).norm();
      const Vec3 out = (hand - nearest(hand)) / outside;
      const Vec3 force = 1000.0 * (radius - outside) * out;
      // At most 2 um apart; and a row's unnoticed rotation, some 1.5 mrad, moves the ball further
      // in proportion to the hand's depth.
      const double unseen = 1.5e-3 * radius / outside;
      ASSERT_LT((report.wrench.force - force).norm(), 2e-3 + unseen * force.norm()) << i;
      turned += std::acos(std::min(1.0, out.dot(last)));
      last = out;
    }
    EXPECT_LE(touch.far, 15);
    EXPECT_GT(turned, 30.0) << "the hand hardly went round anything";
  }
}

TEST(MeshContact, FeelsAReliefByItsSlopeAlone) {
  // Waves of 10 um, 27 mm long: a slope of 2.4 mrad, 7 mN of 3 N.
  Touch touch(
      MakeScene(MakeMeshBody("ball", MakeSphere(0.01, 320)),
                MakeMeshBody("floor", test::MakeBlock(24, 0.04, 0.02, test::Waves(1e-5, 0.04)))),
      Vec3(-0.02, -0.01, 0.011));
  touch.Go({Vec3(-0.02, -0.01, 0.007), Quat::Identity()}, 40);
  for (int i = 1; i <= 400; ++i) {
    const StepReport report =
        touch.Step({Vec3(-0.02 + 1e-4 * i, -0.01 + 5e-5 * i, 0.007), Quat::Identity()});
    EXPECT_LE(report.wrench.force.head<2>().norm(), 0.008) << i;
  }
}

TEST(MeshContact, HoldsAnEdgeThatCrossesAnEdge) {
  // Two bars, each standing on an edge: only the edges meet, and their cross product is vertical.
  const double bar = 0.01, edge = bar * M_SQRT1_2;
  const Body low = Box(Vec3(0.1, bar, bar), {Vec3::Zero(), Turn(45.0, Vec3::UnitX())});
  for (const double degrees : {90.0, 60.0, 20.0}) {
    SCOPED_TRACE(testing::Message() << degrees << " degrees");
    const Quat q = Turn(degrees, Vec3::UnitZ()) * Turn(45.0, Vec3::UnitX());
    Touch touch(MakeScene(Box(Vec3(0.1, bar, bar)), low), Pose{Vec3(0, 0, 2 * edge + 0.001), q});
    const StepReport report = touch.Go({Vec3(0, 0, 2 * edge - 0.003), q}, 60);
    ExpectForce(report, Vec3::UnitZ(), 0.003);
    ASSERT_GE(report.contacts, 1);
    EXPECT_FALSE(report.active[0].id.IsOfLeaves());
    EXPECT_NEAR(touch.state.X_WG.p.z(), 2 * edge, 2e-6);
    // Drawn along the lower edge, the upper one stays on it without resistance.
    for (int i = 1; i <= 200; ++i) {
      ExpectForce(touch.Step({Vec3(1e-4 * i, 0, 2 * edge - 0.003), q}), Vec3::UnitZ(), 0.003);
    }
  }
}

TEST(MeshContact, HoldsAThinSheetFromEitherSide) {
  const TriangleMesh sheet = test::MakeSheet(8, 0.04, test::Flat);
  for (const double side : {1.0, -1.0}) {
    for (const int steps : {40, 400}) {
      // 20 mm, at 0.5 m/s and at 0.05 m/s.
      Touch touch(MakeScene(Box(Vec3(0.02, 0.02, 0.01)), MakeMeshBody("sheet", sheet)),
                  Vec3(0.003, 0.002, 0.0051 * side));
      const StepReport report =
          touch.Go({Vec3(0.003, 0.002, -0.015 * side), Quat::Identity()}, steps);
      ExpectForce(report, Vec3(0, 0, side), 0.02);
      EXPECT_NEAR(touch.state.X_WG.p.z(), 0.005 * side, 2e-6);
    }
  }
}

/// A block with a square hole through it along z, its top at z = 0.
TriangleMesh MakeSocket(double hole, double outer, double depth) {
  TriangleMesh mesh;
  for (const double z : {0.0, -depth}) {
    for (const double half : {0.5 * hole, 0.5 * outer}) {
      for (const auto& [x, y] : {std::pair{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}) {
        mesh.vertices.push_back({half * x, half * y, z});
      }
    }
  }
  // Vertices: 0 to 3 the hole's top, 4 to 7 the block's top, 8 to 15 the same at the bottom.
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (std::uint32_t i = 0; i < 4; ++i) {
    const std::uint32_t j = (i + 1) % 4;
    quad(i, i + 4, j + 4, j);            // top
    quad(i + 8, j + 8, j + 12, i + 12);  // bottom
    quad(i + 4, i + 12, j + 12, j + 4);  // outside
    quad(i, j, j + 8, i + 8);            // the hole's walls
  }
  return mesh;
}

TEST(MeshContact, LetsAPegSlideInAHoleWithFiftyMicrometres) {
  Touch touch(MakeScene(Box(Vec3(0.01, 0.01, 0.04)),
                        MakeMeshBody("socket", MakeSocket(0.0101, 0.04, 0.03))),
              Vec3(0.0, 0.0, 0.0205));
  const auto step = [&](const Vec3& p, const Quat& q) {
    const StepReport report = touch.Step({p, q});
    EXPECT_EQ(report.faults, 0u) << "step " << touch.steps;
    return report;
  };
  // Down, pushed sideways by 1 N and turned: the walls hold it, and let it slide along.
  for (int i = 1; i <= 400; ++i) {
    const double aside = std::min(1.0, 0.01 * i);
    const StepReport report = step(Vec3(1e-3 * aside, -4e-4 * aside, 0.0205 - 5e-5 * i),
                                   Turn(2.0 * aside, Vec3(0.3, 1.0, 0.5).normalized()));
    if (i > 100) {
      EXPECT_LE(std::abs(report.wrench.force.z()), 0.15) << i;
    }
  }
  const StepReport held = touch.Go({Vec3(1e-3, -4e-4, 0.0005), Quat::Identity()}, 100, 100);
  EXPECT_NEAR(held.wrench.force.x(), -0.95, 0.01);
  EXPECT_NEAR(held.wrench.force.y(), 0.35, 0.01);
  EXPECT_NEAR(held.wrench.force.z(), 0.0, 0.01);
  EXPECT_NEAR(touch.state.X_WG.p.x(), 5e-5, 2e-6);
}

// A hand that turns a peg further than its hole allows, so that it often does not arrive.
TEST(MeshContact, FollowsAHandThatTwistsAPegInItsHole) {
  const auto wall = [](const Vec3& at, const Quat& q) {
    Body body = Box(Vec3(0.01205, 0.04, 0.001));
    body.X_WB = {at, q};
    return body;
  };
  const double off = 0.5 * (0.01005 + 0.001);  // the hole is 50 um wider than the peg
  const Quat quarter = Turn(90.0, Vec3::UnitY()), none = Quat::Identity();
  Scene scene = MakeScene(Box(Vec3(0.01, 0.03, 0.01)), wall(Vec3(0, 0, off), none));
  scene.objects.push_back(wall(Vec3(0, 0, -off), none));
  scene.objects.push_back(wall(Vec3(off, 0, 0), quarter));
  scene.objects.push_back(wall(Vec3(-off, 0, 0), quarter));
  Touch touch(std::move(scene), Vec3::Zero());
  for (int i = 0; i < 3000; ++i) {
    const double in = std::min(1.0, 0.01 * i);
    const Vec3 at(0.8 * std::sin(0.21 * i), 8 * std::sin(0.03 * i), 0.8 * std::cos(0.17 * i));
    const Vec3 turn = 0.06 * in * Vec3(std::sin(0.05 * i), std::sin(0.07 * i), std::cos(0.03 * i));
    touch.Step({1e-3 * in * at, RotationExp(turn)});
  }
  EXPECT_LE(touch.far, 3);  // one in a thousand
}

// A rod in a channel, and a hand that turns round and round, and back again.
TEST(MeshContact, ResistsATurnBeyondHalfATurnTheSameWay) {
  Scene scene =
      MakeScene(Box(Vec3(0.1, 0.01, 0.01)), Box(Vec3(0.12, 0.02, 0.04), {Vec3(0.0, 0.0152, 0.0)}));
  scene.objects.push_back(Box(Vec3(0.12, 0.02, 0.04), {Vec3(0.0, -0.0152, 0.0)}));
  scene.objects.push_back(Box(Vec3(0.12, 0.05, 0.02), {Vec3(0.0, 0.0, 0.0152)}));
  scene.objects.push_back(Box(Vec3(0.12, 0.05, 0.02), {Vec3(0.0, 0.0, -0.0152)}));
  Touch touch(std::move(scene), Vec3::Zero());
  const auto hand = [](double degrees) {
    // With a tremble of a degree about other axes.
    return Pose{Vec3::Zero(), Turn(std::sin(0.2 * degrees), Vec3(1.0, 0.5, 0.0).normalized()) *
                                  Turn(degrees, Vec3::UnitZ())};
  };
  Vec3 before = Vec3::Zero();
  for (int i = 0; i < 800; ++i) {
    const double degrees = 2.0 * (i < 400 ? i : 800 - i);
    const Vec3 torque = touch.Step(hand(degrees)).wrench.torque;
    // The channel lets the rod turn by a quarter of a degree.
    if (degrees > 0.0) {
      ASSERT_NEAR(torque.z(), -std::min(degrees * M_PI / 180.0, 2.0 * M_PI), 0.01) << degrees;
    }
    ASSERT_LT((torque - before).norm(), 0.05) << degrees;
    before = torque;
  }
  // Drawn out of the channel, the tool turns to the hand the shorter way.
  for (int i = 0; i <= 100; ++i) touch.Step(hand(2.0 * i));
  StepReport report;
  for (int i = 0; i < 300; ++i) {
    report = touch.Step({Vec3(0.5e-3 * i, 0.0, 0.0), Turn(200.0, Vec3::UnitZ())});
  }
  EXPECT_EQ(report.wrench.torque, Vec3::Zero());
  EXPECT_EQ(report.faults, 0u);
  EXPECT_EQ(touch.state.rotation_G, Vec3::Zero());
}

TEST(MeshContact, SlidesIntoAConcaveEdgeAndIsHeldByBothFaces) {
  Touch touch(MakeScene(Box(Vec3::Constant(0.02)), MakeMeshBody("L", test::MakeL(0.06))),
              Vec3(0.016, 0.0, 0.016));
  // The L's faces lie at x = 0 and z = 0: the 10 mm box goes into the corner.
  const StepReport report = touch.Go({Vec3(0.008, 0.005, 0.007), Quat::Identity()}, 100);
  EXPECT_NEAR(report.wrench.force.x(), 2.0, 2e-3);
  EXPECT_NEAR(report.wrench.force.z(), 3.0, 2e-3);
  EXPECT_NEAR(report.wrench.force.y(), 0.0, 2e-3);
  for (int i = 1; i <= 200; ++i) {
    const StepReport slid = touch.Step({Vec3(0.008, 0.005 - 1e-4 * i, 0.007), Quat::Identity()});
    EXPECT_NEAR(slid.wrench.force.y(), 0.0, 0.01);
    EXPECT_NEAR(slid.wrench.force.x(), 2.0, 0.01);
  }
}

TEST(MeshContact, GoesOnWithWideBoundsWhereItHasFallenBehind) {
  Touch touch(MakeScene(Box(Vec3::Constant(0.01)), Box(Vec3::Constant(0.06))),
              Vec3(0.0, 0.0, 0.035001));
  touch.Step({Vec3(0, 0, 0.0345), Quat::Identity()});
  // A jump of 20 mm along the face: more than a cycle's sub-steps reach.
  const StepReport far = touch.Step({Vec3(0.02, 0, 0.0345), Quat::Identity()});
  ASSERT_NE(far.faults & kFaultTargetFar, 0u);
  EXPECT_GT(touch.state.behind.translation, 50e-6);
  // Under way along the face, the tool feels the same force as at the end.
  EXPECT_NEAR(far.wrench.force.z(), 0.5, 2e-3);
  EXPECT_NEAR(far.wrench.force.x(), 0.0, 2e-3);
  StepReport report;
  for (int i = 0; i < 100; ++i) report = touch.Step({Vec3(0.02, 0, 0.0345), Quat::Identity()});
  EXPECT_EQ(report.faults, 0u);
  EXPECT_EQ(touch.state.behind.translation, 0.0);
  EXPECT_NEAR(report.X_WG.p.x(), 0.02, 1e-9);
}

// Half of the ball lies within 0.2 mm of its socket: a long candidate costs more looks than a cycle
// has.
TEST(MeshContact, ArrivesInASocketWithinTwoHundredCyclesOfAHandThatRests) {
  TriangleMesh socket = MakeSphere(0.0151, 5120);
  std::erase_if(socket.triangles, [&](const auto& corners) {
    return std::ranges::any_of(corners, [&](auto v) { return socket.vertices[v].z() > 0.0; });
  });
  Touch touch(MakeScene(MakeMeshBody("ball", MakeSphere(0.015, 5120)),
                        MakeMeshBody("socket", std::move(socket))),
              Vec3::Zero());
  const Vec3 down(0.3e-3, 0.5e-3, -3e-3);
  const StepReport report = touch.Go({down, Quat::Identity()}, 60, 200);
  EXPECT_EQ(report.faults & kFaultTargetFar, 0u) << touch.far << " steps had not arrived";
  EXPECT_GT(report.wrench.force.norm(), 1.0);
}

TEST(MeshContact, StaysOutsideWhereTheHandJumpsFiftyMillimetresThrough) {
  Touch touch(MakeScene(Box(Vec3::Constant(0.02)), Box(Vec3(0.1, 0.1, 0.01))),
              Vec3(0.0, 0.0, 0.025));
  touch.Step({Vec3(0, 0, 0.025), Quat::Identity()});
  const Quat turned = Turn(90.0, Vec3(1.0, 0.2, 0.3).normalized());
  for (int i = 0; i < 200; ++i) touch.Step({Vec3(0.0, 0.0, -0.025), turned});
  EXPECT_GT(touch.state.X_WG.p.z(), 0.014);
  EXPECT_GT(touch.Step({Vec3(0.0, 0.0, -0.025), turned}).wrench.force.z(), 10.0);
  for (int i = 0; i < 200; ++i) touch.Step({Vec3(0.0, 0.0, 0.025), Quat::Identity()});
  EXPECT_EQ(touch.state.X_WG.p, Vec3(0.0, 0.0, 0.025));
}

TEST(MeshContact, BeginsOutsideWhereverTheHandDoes) {
  struct Case {
    TriangleMesh tool, object;
  };
  const Case cases[] = {{MakeBox(Vec3(0.02, 0.01, 0.03)), MakeBox(Vec3(0.06, 0.05, 0.04))},
                        {MakeSphere(0.01, 80), test::MakeL(0.06)},
                        {MakeBox(Vec3::Constant(0.02)), test::MakeSheet(4, 0.04, test::Flat)}};
  for (const Case& c : cases) {
    // With whole trees, which the search for a start pose follows.
    Touch touch(test::MakeScene(c.tool, 64, c.object, 64, ContactModel::kSurface), Vec3::Zero());
    Random random(62);
    for (int candidate = 0; candidate < 20; ++candidate) {
      const Pose X{random.InCube(0.03), random.Rotation()};
      const StartPose start = ResolveStart(touch.model, X, touch.workspace);
      EXPECT_FALSE(touch.oracle.Meet(start.X_WG)) << "candidate " << candidate;
      touch.state = StepState(touch.model);
      touch.state.X_WG = start.X_WG;
      touch.state.X_WH = X;
      for (int i = 0; i < 10; ++i) touch.Step(X);
    }
  }
}

TEST(MeshContact, ComesOutWhereAStateIsSetAcrossASheet) {
  // No step leads there, but a caller can set such a state.  A corner of the box is 50 um through.
  const Quat q = RotationBetween(Vec3(1, 1, 1).normalized(), -Vec3::UnitZ());
  const double height = 0.01 * std::sqrt(3.0);
  Touch touch(MakeScene(Box(Vec3::Constant(0.02)),
                        MakeMeshBody("sheet", test::MakeSheet(4, 0.04, test::Flat))),
              Pose{Vec3(0.003, 0.002, height - 5e-5), q});
  ASSERT_TRUE(touch.oracle.Meet(touch.state.X_WG));
  for (int i = 0; i < 100; ++i) {
    HapticStep(touch.model, {Vec3(0.003, 0.002, 0.03), q}, touch.state, touch.workspace);
  }
  EXPECT_EQ(touch.state.X_WG.p, Vec3(0.003, 0.002, 0.03));
}

/// Everything a step reports of a tool's pose and force.
std::vector<double> Bits(const StepReport& report) {
  const Pose& X = report.X_WG;
  const Wrench& f = report.wrench;
  return {X.p.x(),     X.p.y(),     X.p.z(),     X.q.w(),      X.q.x(),      X.q.y(),     X.q.z(),
          f.force.x(), f.force.y(), f.force.z(), f.torque.x(), f.torque.y(), f.torque.z()};
}

/// Rolls and slides one waved block, pressed on another.
Pose Rolling(int i) {
  const double s = 0.01 * i;
  return {
      Vec3(0.004 * std::sin(s), 0.003 * std::cos(1.3 * s), 0.001 + 0.002 * std::sin(2.1 * s)),
      RotationExp(Vec3(0.05 * std::sin(1.7 * s), M_PI + 0.05 * std::cos(s), 0.2 * std::sin(s)))};
}
Scene WavesOnWaves() {
  return test::MeshScene(test::MakeBlock(8, 0.015, 0.01, test::Waves(0.001, 0.015)),
                         test::MakeBlock(16, 0.03, 0.02, test::Waves(0.001, 0.03)));
}

TEST(MeshContact, ACopyOfItsStateGoesOnToTheSameBits) {
  Touch touch(WavesOnWaves(), Pose{Vec3(0, 0, 0.02), Rolling(0).q});
  touch.Go(Rolling(0), 60);
  int held = 0;
  for (int i = 0; i < 600; i += 100) {
    StepState copy = touch.state;
    StepWorkspace other(touch.model);
    std::vector<std::vector<double>> first;
    for (int k = 0; k < 100; ++k) {
      const StepReport report = touch.Step(Rolling(i + k));
      held += report.contacts > 0;
      first.push_back(Bits(report));
    }
    for (std::size_t k = 0; k < 100; ++k) {
      const StepReport again =
          HapticStep(touch.model, Rolling(i + static_cast<int>(k)), copy, other);
      ASSERT_EQ(Bits(again), first[k]) << "step " << i + static_cast<int>(k);
    }
  }
  EXPECT_GT(held, 300);
}

TEST(MeshContact, RegainsItsSeparationTooGentlyToBeFelt) {
  // Placed 0.2 um above the floor: 1 um is required, regained by 0.3 um per sub-step, at rest and
  // while it moves.
  Touch touch(MakeScene(Box(Vec3::Constant(0.02)), Box(Vec3(0.1, 0.1, 0.02))),
              Vec3(0.0, 0.0, 0.02 + 2e-7));
  double before = touch.state.X_WG.p.z();
  for (int i = 0; i < 20; ++i) {
    const StepReport report = touch.Step({Vec3(0.0, 0.0, 0.0199), Quat::Identity()});
    EXPECT_LE(report.X_WG.p.z() - before, 0.31e-6 * report.diagnostics.substeps);
    EXPECT_NEAR(report.wrench.force.z(), 0.1, 1.1e-3);
    before = report.X_WG.p.z();
  }
  EXPECT_NEAR(before, 0.020001, 1e-9);
  for (int i = 0; i < 20; ++i) {
    const StepReport report = touch.Step({Vec3(5e-5 * i, 0.0, 0.0199), Quat::Identity()});
    EXPECT_LE(report.X_WG.p.z() - before, 0.31e-6 * report.diagnostics.substeps);
    EXPECT_NEAR(report.wrench.force.z(), 0.1, 1.1e-3);
    before = report.X_WG.p.z();
  }
  EXPECT_NEAR(touch.state.X_WG.p.z(), 0.02 + 1e-6, 1e-8);
}

TEST(MeshContact, BeginsWithTheRowsThatHeldItLast) {
  Touch touch(WavesOnWaves(), Pose{Vec3(0, 0, 0.02), Rolling(0).q});
  touch.Go(Rolling(0), 60);
  int held = 0, began = 0;
  for (int i = 0; i < 300; ++i) {
    const int contacts = touch.state.active.count;
    const StepReport report = touch.Step(Rolling(i));
    if (contacts == 0 || report.contacts == 0 || report.diagnostics.substeps != 1) continue;
    ++held;
    began += report.diagnostics.predicted_pairs > 0;
  }
  EXPECT_GT(held, 100);
  // Except where another pair has taken over the contact.
  EXPECT_GT(began, held * 9 / 10);
}

TEST(MeshContact, AllocatesNothingInAStep) {
  Touch touch(WavesOnWaves(), Pose{Vec3(0, 0, 0.02), Rolling(0).q});
  const std::uint64_t before = test::AllocationsOfThisThread();
  for (int i = 0; i < 300; ++i) {
    // From the first step, and across jumps of the hand.
    const Pose X = i % 100 == 99 ? Pose{Vec3(0.0, 0.03, 0.01), Quat::Identity()} : Rolling(i);
    HapticStep(touch.model, X, touch.state, touch.workspace);
  }
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
}

TEST(MeshContact, AllocatesNothingWhereABallGoesRoundAnEdge) {
  const double half = 0.025;
  Touch touch(MakeScene(BallBody(0.005), Box(Vec3::Constant(2.0 * half))), Vec3(0.0, half, 0.032));
  const std::uint64_t before = test::AllocationsOfThisThread();
  int held = 0;
  for (int i = 0; i < 200; ++i) {
    const double angle = 0.01 * i;
    const Vec3 hand(0.0, half + 0.002 * std::sin(angle), half + 0.002 * std::cos(angle));
    held +=
        HapticStep(touch.model, {hand, Quat::Identity()}, touch.state, touch.workspace).contacts;
  }
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
  EXPECT_GT(held, 100);
}

}  // namespace
}  // namespace palpate
