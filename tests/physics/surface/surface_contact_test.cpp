#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes.h"
#include "scenes/sphere_tree_builder.h"
#include "server/physics/haptic_step.h"
#include "server/physics/scene_model.h"
#include "server/physics/surface/body_surfaces.h"
#include "server/physics/surface/contact_surface.h"
#include "server/physics/surface/surface_mesh.h"
#include "server/physics/surface/surface_tree.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;

Body MakeBody(TriangleMesh mesh, std::size_t leaves, const Vec3& at = Vec3::Zero()) {
  Body body;
  body.mesh = std::move(mesh);
  body.tree = BuildSphereTree(body.mesh, leaves);
  body.X_WB.p = at;
  return body;
}

Scene MakeScene(Body tool, Body object) {
  Scene scene;
  scene.tools.push_back(std::move(tool));
  scene.objects.push_back(std::move(object));
  return scene;
}

/// A scene's first tool and its state.
struct Touch {
  explicit Touch(Scene s, const Vec3& start)
      : scene(std::move(s)),
        model(MakeModel(scene, scene.tools.front(), MakeObjects(scene))),
        workspace(model),
        state(model) {
    state.X_WG.p = state.X_WH.p = start;
  }
  StepReport Step(const Pose& X_WH) { return HapticStep(model, X_WH, state, workspace); }

  Scene scene;
  HapticModel model;
  StepWorkspace workspace;
  StepState state;
};

Vec3 Corner(const SurfacePatch& patch, int corner) {
  const Vec3 p0(patch.p0[0], patch.p0[1], patch.p0[2]);
  if (corner == 0) return p0;
  const double* e = corner == 1 ? patch.e1 : patch.e2;
  return p0 + Vec3(e[0], e[1], e[2]);
}

TEST(SurfaceMesh, HalvesEdgesOnTheCurvedSurfaceUntilNoneIsLonger) {
  const double radius = 0.03;
  const SurfaceMesh mesh = MakeSurfaceMesh(MakeSphere(radius, 1280), 0.001);
  for (const SurfaceMesh::Triangle& t : mesh.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3 &a = mesh.vertices[t.vertex[c]], &b = mesh.vertices[t.vertex[(c + 1) % 3]];
      EXPECT_LE((a - b).norm(), 0.001);
      // Chords of e = 5 mm lie e^2 / 8R = 100 um inside the sphere, the parabolas over them
      // 3/8 R (e / 2R)^4 = 0.54 um.
      EXPECT_NEAR(a.norm(), radius, 0.6e-6);
      EXPECT_GT(t.normal[c].dot(a) / a.norm(), 1.0 - 1e-5);
    }
  }
  EXPECT_TRUE(mesh.sharp_edges.empty());
}

TEST(SurfaceMesh, KeepsCreasesSharpAndFacesFlat) {
  const SurfaceMesh mesh = MakeSurfaceMesh(MakeBox(Vec3(0.02, 0.03, 0.04)), 0.005);
  double length = 0.0;
  for (const SurfaceMesh::SharpEdge& edge : mesh.sharp_edges) {
    EXPECT_TRUE(edge.convex);
    length += (mesh.vertices[edge.vertex[0]] - mesh.vertices[edge.vertex[1]]).norm();
  }
  EXPECT_NEAR(length, 4 * (0.02 + 0.03 + 0.04), 1e-12);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const Vec3& n : mesh.triangles[i].normal) {
      EXPECT_NEAR((n - mesh.FaceNormal(i)).norm(), 0.0, 1e-12);
    }
  }
}

// What the prediction rests on: every place of the surface lies in a patch, every patch in the ball
// of its leaf, and in the balls of all nodes above it.
TEST(SurfaceMesh, DropsTrianglesThatLieBackToBackAndJoinsTheirNeighbours) {
  TriangleMesh fin = MakeBox(Vec3::Constant(0.02));
  const SurfaceMesh without = MakeSurfaceMesh(fin, 1.0);
  const auto [i, j, k] = fin.triangles.front();
  // A fin within a face: the same corners, either way round, and once more the face itself.
  fin.triangles.insert(fin.triangles.end(), {{j, i, k}, {j, k, i}});
  const SurfaceMesh with = MakeSurfaceMesh(fin, 1.0);
  ASSERT_EQ(with.triangles.size(), without.triangles.size() - 1);
  EXPECT_EQ(with.sharp_edges.size(), without.sharp_edges.size() + 1);  // the face is open there

  TriangleMesh closed = MakeBox(Vec3::Constant(0.02));
  const std::size_t corner = closed.vertices.size();
  closed.vertices.push_back(Vec3(0.02, 0.02, 0.02));
  const auto c = static_cast<std::uint32_t>(corner);
  closed.triangles.insert(closed.triangles.end(), {{i, j, c}, {i, c, j}});
  const SurfaceMesh mended = MakeSurfaceMesh(closed, 1.0);
  EXPECT_EQ(mended.triangles.size(), without.triangles.size());
  EXPECT_EQ(mended.sharp_edges.size(), without.sharp_edges.size());
}

TEST(ContactSurface, FacesWhatItsCreasesAndCornersCanTouch) {
  const Body box = MakeBody(MakeBox(Vec3::Constant(0.02)), 64);
  const ContactSurface surface(box.mesh, box.tree, Pose{});
  ASSERT_FALSE(surface.points.empty());
  for (const SurfacePoint& point : surface.points) {
    // Faces that the point lies on: planes of these normals may touch it, from outside.
    Vec3 out = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
      if (std::abs(std::abs(point.x[i]) - 0.01) < 1e-12) out[i] = point.x[i] > 0.0 ? 1.0 : -1.0;
    }
    ASSERT_GE(out.norm(), 1.4);
    const Vec3 m(point.m[0], point.m[1], point.m[2]);
    for (int i = 0; i < 3; ++i) {
      if (out[i] == 0.0) continue;
      EXPECT_GT(out[i] * m[i], point.cosine) << "touches a plane that lies on this face";
      EXPECT_LT(-out[i] * m[i], point.cosine) << "and none that looks the same way";
    }
  }
}

TEST(ContactSurface, LeavesNoPlaceOfTheSurfaceOutOfAnyLevelOfItsTree) {
  for (const std::size_t leaves : {64u, 512u}) {
    const Body body = MakeBody(MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 1280), leaves);
    const ContactSurface surface(body.mesh, body.tree, body.X_WB);
    double area = 0.0, mesh_area = 0.0;
    for (const auto& [i, j, k] : body.mesh.triangles) {
      const Vec3& a = body.mesh.vertices[i];
      mesh_area += 0.5 * (body.mesh.vertices[j] - a).cross(body.mesh.vertices[k] - a).norm();
    }
    const SphereTree& tree = surface.patch_tree;
    ASSERT_EQ(tree.leaves(), surface.patches.size());
    // Leaves below each node, from the last level up; each must hold the corners of all of them.
    std::vector<std::vector<std::size_t>> below(tree.leaves());
    for (std::size_t i = 0; i < tree.leaves(); ++i) {
      below[i] = {i};
      const SurfacePatch& patch = surface.patches[i];
      area +=
          0.5 *
          (Corner(patch, 1) - Corner(patch, 0)).cross(Corner(patch, 2) - Corner(patch, 0)).norm();
      const Vec3 centre(tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]);
      for (int c = 0; c < 3; ++c) {
        EXPECT_LE((Corner(patch, c) - centre).norm(), tree.leaf_radius[i] + 1e-12);
      }
    }
    EXPECT_GE(area, mesh_area * (1.0 - 1e-9));
    for (int l = tree.levels() - 1; l >= 0; --l) {
      std::vector<std::vector<std::size_t>> here;
      for (const SpherePacket& packet : tree.level(l)) {
        std::vector<std::size_t> all;
        for (int lane = 0; lane < kTreeArity; ++lane) {
          if (packet.child[lane] < 0) continue;
          const Vec3 centre(packet.x[lane], packet.y[lane], packet.z[lane]);
          for (const std::size_t i : below[static_cast<std::size_t>(packet.child[lane])]) {
            for (int c = 0; c < 3; ++c) {
              EXPECT_LE((Corner(surface.patches[i], c) - centre).norm(), packet.radius[lane]);
            }
            all.push_back(i);
          }
        }
        here.push_back(std::move(all));
      }
      below = std::move(here);
    }
    ASSERT_EQ(below.size(), 1u);
    EXPECT_EQ(std::set<std::size_t>(below[0].begin(), below[0].end()).size(), tree.leaves());
  }
}

// A ball among the leaves of a sparse tree: wherever it comes from, the surface stops it.
TEST(SurfaceContact, HasNoGapThroughWhichABallCanFall) {
  Body ball;
  ball.mesh = MakeSphere(0.001, 320);
  ball.tree = SingleSphereTree(ball.mesh, {Vec3::Zero(), 0.001});
  Touch touch(MakeScene(ball, MakeBody(MakeBox(Vec3::Constant(0.05)), 64)), Vec3(0.0, 0.0, 0.05));
  Random random(3);
  for (int trial = 0; trial < 40; ++trial) {
    const Vec3 from = 0.06 * random.InCube(1.0).normalized();
    touch.state = StepState(touch.model);
    touch.state.X_WG.p = touch.state.X_WH.p = from;
    for (int i = 1; i <= 300; ++i) {
      // To the cube's middle at 0.2 m/s.
      touch.Step({from * (1.0 - i / 300.0), Quat::Identity()});
      const Vec3 out = (touch.state.X_WG.p.cwiseAbs().array() - 0.025).matrix().cwiseMax(0.0);
      ASSERT_GE(out.norm(), 0.001 - 1e-6) << "trial " << trial << ", step " << i;
    }
  }
}

TEST(SurfaceContact, GivesTheAnalyticForceOnAFlatFaceAtAnyLeafCount) {
  for (const std::size_t leaves : {64u, 700u}) {
    Body ball;
    ball.mesh = MakeSphere(0.005, 320);
    ball.tree = SingleSphereTree(ball.mesh, {Vec3::Zero(), 0.005});
    Touch touch(MakeScene(ball, MakeBody(MakeBox(Vec3::Constant(0.05)), leaves)),
                Vec3(-0.015, 0.03, 0.0));
    for (int i = 0; i < 600; ++i) {
      const StepReport report =
          touch.Step({Vec3(-0.015 + 5e-5 * i, 0.029, 0.003), Quat::Identity()});
      if (i == 0) continue;
      EXPECT_NEAR(report.wrench.force.y(), 1.0, 1e-6);
      EXPECT_NEAR(report.wrench.force.x(), 0.0, 1e-6);
      EXPECT_NEAR(report.wrench.force.z(), 0.0, 1e-6);
    }
  }
}

TEST(SurfaceContact, RestsABoxFlatOnAPlaneWithoutTorque) {
  Touch touch(MakeScene(MakeBody(MakeBox(Vec3(0.02, 0.01, 0.02)), 256),
                        MakeBody(MakeBox(Vec3(0.1, 0.02, 0.1)), 512)),
              Vec3(0.0, 0.016, 0.0));
  for (int i = 0; i < 500; ++i) {
    const StepReport report = touch.Step({Vec3(4e-5 * i, 0.014, 2e-5 * i), Quat::Identity()});
    if (i < 20) continue;
    EXPECT_NEAR(report.wrench.force.y(), 1.0, 1e-6);
    EXPECT_LT(report.wrench.torque.norm(), 1e-9);
    EXPECT_LT(RotationLog(report.X_WG.q).norm(), 1e-9);
  }
}

TEST(SurfaceContact, HoldsAnEdgeThatCrossesAnEdge) {
  // Two bars crossed, each standing on an edge: only the creases meet.
  const double bar = 0.01, edge = bar * M_SQRT1_2;
  Body low = MakeBody(MakeBox(Vec3(0.1, bar, bar)), 256);
  low.X_WB.q = Quat(Eigen::AngleAxisd(M_PI / 4, Vec3::UnitX()));
  Body high = MakeBody(MakeBox(Vec3(bar, bar, 0.1)), 256);
  const Quat q(Eigen::AngleAxisd(M_PI / 4, Vec3::UnitZ()));
  Touch touch(MakeScene(high, low), Vec3(0.0003, 2 * edge + 0.001, 0.0002));
  touch.state.X_WG.q = touch.state.X_WH.q = q;
  StepReport report;
  for (int i = 0; i < 50; ++i) {
    report = touch.Step({Vec3(0.0003, 2 * edge + 0.001 - 4e-5 * i, 0.0002), q});
  }
  ASSERT_EQ(report.contacts, 1);
  EXPECT_EQ(KindOf(report.active[0].pair), RowKind::kCreases);
  EXPECT_NEAR(report.wrench.force.y(), 0.96, 0.03);  // the touch lies 0.3 mm off the middle
  EXPECT_NEAR(touch.state.X_WG.p.y(), 2 * edge, 5e-6);
}

TEST(SurfaceContact, RubsAsCoulombSays) {
  Scene scene = MakeScene(MakeBody(MakeBox(Vec3::Constant(0.01)), 128),
                          MakeBody(MakeBox(Vec3(0.2, 0.06, 0.06)), 512));
  scene.features.friction = FrictionModel::kCoulomb;
  scene.objects[0].materials = {Material{.static_friction = 0.8, .dynamic_friction = 0.3}};
  Touch touch(std::move(scene), Vec3(-0.05, 0.0, 0.035001));
  // 1 N down, and 0.6 N along: less than 0.8 N holds, for as long as it lasts.
  const Vec3 pressed(-0.05, 0.0, 0.034);
  StepReport report;
  for (int i = 0; i < 50; ++i) report = touch.Step({pressed, Quat::Identity()});
  const Vec3 stuck = report.X_WG.p;
  for (int i = 0; i < 500; ++i) {
    const double along = 0.6e-3 * std::min(1.0, 0.01 * i);
    report = touch.Step({pressed + Vec3(along, 0, 0), Quat::Identity()});
  }
  EXPECT_NEAR(report.wrench.force.x(), -0.6, 1e-6);
  EXPECT_NEAR((report.X_WG.p - stuck).norm(), 0.0, 1e-9);
  // Drawn along at 0.1 m/s it slides, and the force is mu_d times the normal one.
  for (int i = 0; i < 600; ++i) {
    report = touch.Step({pressed + Vec3(0.6e-3 + 1e-4 * i, 0, 0), Quat::Identity()});
    if (i < 100) continue;
    const Vec3& f = report.wrench.force;
    EXPECT_NEAR(-f.x() / f.z(), 0.3, 0.003) << i;
    EXPECT_NEAR(f.z(), 1.0, 0.01);
    EXPECT_NEAR(f.y(), 0.0, 1e-6);
  }
}

TEST(SurfaceContact, GoesOnWithWideBoundsWhereItHasFallenBehind) {
  Touch touch(MakeScene(MakeBody(MakeBox(Vec3::Constant(0.01)), 128),
                        MakeBody(MakeBox(Vec3(0.06, 0.06, 0.06)), 512)),
              Vec3(0.0, 0.0, 0.035001));
  touch.Step({Vec3(0, 0, 0.0345), Quat::Identity()});
  // 20 mm along the face at once: more than a cycle's sub-steps reach near a surface.
  const StepReport far = touch.Step({Vec3(0.02, 0, 0.0345), Quat::Identity()});
  ASSERT_NE(far.faults & kFaultTargetFar, 0u);
  EXPECT_GT(touch.state.behind.translation, 50e-6);
  StepReport report;
  for (int i = 0; i < 100; ++i) report = touch.Step({Vec3(0.02, 0, 0.0345), Quat::Identity()});
  EXPECT_EQ(report.faults, 0u);
  EXPECT_EQ(touch.state.behind.translation, 0.0);
  EXPECT_NEAR(report.X_WG.p.x(), 0.02, 1e-9);
}

TEST(SurfaceContact, KeepsSoftBodiesToTheirLeaves) {
  Body object = MakeBody(MakeBox(Vec3::Constant(0.02)), 64);
  object.materials = {Material{.stiffness = 500.0}};
  const PlacedTree placed{&object.tree, object.X_WB, &object.mesh, {}, object.materials};
  EXPECT_FALSE(HasSurface(placed));
  const ObjectSurfaces surfaces(std::span(&placed, 1));
  EXPECT_TRUE(surfaces.patches.empty());
}

TEST(SurfaceContact, NamesTheRemedyWhereAMeshIsMissing) {
  const Body object = MakeBody(MakeBox(Vec3::Constant(0.02)), 64);
  const PlacedTree placed{.tree = &object.tree, .X_WB = {}, .mesh = nullptr};
  try {
    const ObjectSurfaces surfaces(std::span(&placed, 1));
    FAIL();
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("spheres"), std::string::npos);
  }
}

}  // namespace
}  // namespace palpate
