#include "server/physics/surface/contact_mesh.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;

ContactMesh Place(TriangleMesh mesh, const Pose& X = {}) {
  for (Vec3& v : mesh.vertices) v = X * v;
  return ContactMesh(mesh);
}

std::uint32_t VertexAt(const ContactMesh& mesh, const Vec3& x) {
  for (std::uint32_t v = 0; v < mesh.vertices().size(); ++v) {
    if ((mesh.vertices()[v] - x).norm() < 1e-12) return v;
  }
  ADD_FAILURE() << "no vertex there";
  return 0;
}

std::uint32_t EdgeBetween(const ContactMesh& mesh, const Vec3& a, const Vec3& b) {
  const std::uint32_t i = VertexAt(mesh, a), j = VertexAt(mesh, b);
  for (const ContactMesh::Triangle& t : mesh.triangles()) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t p = t.vertex[c], q = t.vertex[(c + 1) % 3];
      if ((p == i && q == j) || (p == j && q == i)) return t.edge[c];
    }
  }
  ADD_FAILURE() << "no edge there";
  return 0;
}

/// In the plane perpendicular to the x axis, `degrees` from y towards z.
Vec3 Turned(double degrees) {
  return {0.0, std::cos(degrees * M_PI / 180), std::sin(degrees * M_PI / 180)};
}

/// Faces that meet along the x axis from 0 to 1, each at an angle from y towards z.
TriangleMesh Fan(std::initializer_list<double> degrees) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3::Zero(), Vec3::UnitX()};
  for (const double angle : degrees) {
    mesh.vertices.push_back(Vec3(0.4, 0.0, 0.0) + Turned(angle));
    mesh.triangles.push_back({0, 1, static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  }
  return mesh;
}

void ExpectEdgeCone(std::initializer_list<double> faces, double from, double to) {
  const ContactMesh mesh = Place(Fan(faces));
  const std::uint32_t edge = EdgeBetween(mesh, Vec3::Zero(), Vec3::UnitX());
  ASSERT_EQ(mesh.FacesAtEdge(edge).size(), faces.size());
  for (double angle = 0.5; angle < 360.0; angle += 1.0) {
    EXPECT_EQ(mesh.EdgeConeHolds(edge, Turned(angle)), angle > from && angle < to)
        << "at " << angle << " degrees";
  }
}

TEST(ContactMesh, LetsARidgeTouchAlongTheArcBetweenItsFacesNormals) {
  // A roof with faces 30 degrees below the horizon: the cone is more than 90 degrees from both.
  ExpectEdgeCone({-30.0, 210.0}, 60.0, 120.0);
  // A knife's edge.
  ExpectEdgeCone({260.0, 280.0}, 10.0, 170.0);
}

TEST(ContactMesh, LetsAnOpenBorderTouchAlongHalfACircle) {
  ExpectEdgeCone({270.0}, 0.0, 180.0);
}

TEST(ContactMesh, LetsNothingTouchAnEdgeThatFacesSurround) {
  ExpectEdgeCone({0.0, 120.0, 240.0}, 400.0, 400.0);
}

TEST(ContactMesh, LetsAFlatInnerEdgeTouchAlongTheFacesNormalsAlone) {
  const ContactMesh mesh = Place(Fan({0.0, 180.0}));
  const std::uint32_t edge = EdgeBetween(mesh, Vec3::Zero(), Vec3::UnitX());
  for (const double side : {90.0, 270.0}) {
    EXPECT_TRUE(mesh.EdgeConeHolds(edge, Turned(side)));
    for (const double off : {-0.001, 0.001}) {
      EXPECT_FALSE(mesh.EdgeConeHolds(edge, Turned(side + off))) << off << " degrees off";
    }
  }
}

TEST(ContactMesh, LetsAHollowEdgeTouchFromBehindOnly) {
  // A valley open upwards: from above a face is always nearer, from below it is a ridge.
  ExpectEdgeCone({30.0, 150.0}, 240.0, 300.0);
}

TEST(ContactMesh, LetsAFinsFreeEdgeAndItsFootTouchAsTheFacesThereSay) {
  // A fin upright on a floor: above its foot a face is always nearer; below, the floor is flat.
  const ContactMesh mesh = Place(Fan({0.0, 90.0, 180.0}));
  const std::uint32_t foot = EdgeBetween(mesh, Vec3::Zero(), Vec3::UnitX());
  EXPECT_EQ(mesh.FacesAtEdge(foot).size(), 3u);
  for (double angle = 0.5; angle < 360.0; angle += 1.0) {
    EXPECT_FALSE(mesh.EdgeConeHolds(foot, Turned(angle))) << angle;
  }
  EXPECT_TRUE(mesh.EdgeConeHolds(foot, Turned(270.0)));
}

TEST(ContactMesh, LetsABoxCornerTouchInItsOctant) {
  const ContactMesh mesh = Place(MakeBox(Vec3::Constant(0.02)));
  const Vec3 at = Vec3::Constant(0.01);
  const std::uint32_t corner = VertexAt(mesh, at);
  Random random(31);
  for (int candidate = 0; candidate < 2000; ++candidate) {
    const Vec3 n = random.Direction();
    if (n.cwiseAbs().minCoeff() < 1e-5) continue;
    EXPECT_EQ(mesh.VertexConeHolds(corner, n), n.minCoeff() > 0.0);
  }
  EXPECT_TRUE(mesh.VertexConeHolds(corner, Vec3::UnitX()));
}

/// The definition, by distance itself: for a direction in the cone no path over the mesh leads
/// nearer to a far point; for any other direction some path does.
TEST(ContactMesh, AVertexConeIsWhereNoWayAlongTheFacesLeadsNearer) {
  Random random(32);
  for (int candidate = 0; candidate < 300; ++candidate) {
    // A fan of faces about the origin, folded at random: convex, hollow or mixed.
    TriangleMesh fan;
    fan.vertices = {Vec3::Zero()};
    const int faces = 1 + random.Below(6);
    for (int f = 0; f < 2 * faces; ++f) fan.vertices.push_back(random.Direction());
    for (int f = 0; f < faces; ++f) {
      const auto i = static_cast<std::uint32_t>(1 + random.Below(2 * faces));
      const auto j = static_cast<std::uint32_t>(1 + random.Below(2 * faces));
      if (i != j) fan.triangles.push_back({0, i, j});
    }
    if (fan.triangles.empty()) continue;
    const ContactMesh mesh = Place(fan);
    const std::uint32_t corner = VertexAt(mesh, Vec3::Zero());
    const Vec3 n = random.Direction();
    double best = 0.0;
    for (const auto& [o, i, j] : fan.triangles) {
      for (int k = 0; k <= 20; ++k) {
        const double s = k / 20.0;
        best = std::max(best, n.dot((1.0 - s) * fan.vertices[i] + s * fan.vertices[j]));
      }
    }
    if (std::abs(best) < 1e-5 && best > 0.0) continue;
    EXPECT_EQ(mesh.VertexConeHolds(corner, n), best <= 0.0) << "candidate " << candidate;
  }
}

TEST(ContactMesh, WeldsVerticesOfTheSamePlaceSoThatNeighboursKnowEachOther) {
  // A soup: triangles share no vertices.
  const TriangleMesh box = MakeBox(Vec3(0.02, 0.03, 0.04));
  TriangleMesh soup;
  for (const auto& triangle : box.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (const std::uint32_t v : triangle) soup.vertices.push_back(box.vertices[v]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  const ContactMesh mesh = Place(soup, {Vec3(0.3, -0.1, 0.2), RotationExp(Vec3(0.3, 0.2, -0.5))});
  EXPECT_EQ(mesh.vertices().size(), 8u);
  std::set<std::uint32_t> edges;
  for (const ContactMesh::Triangle& t : mesh.triangles()) {
    for (const std::uint32_t e : t.edge) {
      edges.insert(e);
      EXPECT_EQ(mesh.FacesAtEdge(e).size(), 2u);
    }
  }
  EXPECT_EQ(edges.size(), 18u);  // 12 and a diagonal of each face
}

TEST(ContactMesh, ListsTheFacesAtEveryEdgeAndVertex) {
  const ContactMesh mesh = Place(MakeSphere(0.01, 320));
  for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
    const ContactMesh::Triangle& triangle = mesh.triangles()[t];
    for (std::size_t c = 0; c < 3; ++c) {
      const auto at_edge = mesh.FacesAtEdge(triangle.edge[c]);
      EXPECT_EQ(std::count(at_edge.begin(), at_edge.end(), t), 1);
      EXPECT_EQ(at_edge.size(), 2u);
      const auto at_vertex = mesh.FacesAtVertex(triangle.vertex[c]);
      EXPECT_EQ(std::count(at_vertex.begin(), at_vertex.end(), t), 1);
      for (const std::uint32_t face : at_vertex) {
        const auto& v = mesh.triangles()[face].vertex;
        EXPECT_EQ(std::count(v.begin(), v.end(), triangle.vertex[c]), 1);
      }
      // Edge c leads from corner c to the next; the other face has the same two ends.
      for (const std::uint32_t face : at_edge) {
        const auto& v = mesh.triangles()[face].vertex;
        EXPECT_EQ(std::count(v.begin(), v.end(), triangle.vertex[c]), 1);
        EXPECT_EQ(std::count(v.begin(), v.end(), triangle.vertex[(c + 1) % 3]), 1);
      }
    }
    const Vec3 middle = (mesh.Corner(t, 0) + mesh.Corner(t, 1) + mesh.Corner(t, 2)).normalized();
    EXPECT_GT(triangle.normal.dot(middle), 0.99);
    EXPECT_NEAR(triangle.normal.norm(), 1.0, 1e-12);
  }
  EXPECT_NEAR(mesh.reach(), 0.01, 1e-12);
}

TEST(ContactMesh, HasNoNormalWhereATriangleHasNoArea) {
  TriangleMesh flat;
  flat.vertices = {Vec3::Zero(), Vec3::UnitX(), 2.0 * Vec3::UnitX(), Vec3::UnitX()};
  flat.triangles = {{0, 1, 2}, {1, 3, 1}};
  const ContactMesh mesh = Place(flat);
  EXPECT_EQ(mesh.vertices().size(), 3u);
  for (const ContactMesh::Triangle& t : mesh.triangles()) EXPECT_EQ(t.normal, Vec3::Zero());
  // The cones hold nothing non-finite either.
  EXPECT_TRUE(mesh.VertexConeHolds(VertexAt(mesh, Vec3::Zero()), -Vec3::UnitX()));
  EXPECT_FALSE(mesh.VertexConeHolds(VertexAt(mesh, Vec3::Zero()), Vec3::UnitX()));
}

TEST(ContactMesh, APointTouchesInAnyDirection) {
  const ContactMesh point = ContactMesh::Point();
  ASSERT_EQ(point.triangles().size(), 1u);
  EXPECT_EQ(point.reach(), 0.0);
  EXPECT_TRUE(point.FacesAtEdge(0).empty());
  EXPECT_TRUE(point.FacesAtVertex(0).empty());
  Random random(33);
  for (int candidate = 0; candidate < 100; ++candidate) {
    const Vec3 n = random.Direction();
    EXPECT_TRUE(point.VertexConeHolds(point.triangles()[0].vertex[0], n));
    EXPECT_TRUE(point.EdgeConeHolds(point.triangles()[0].edge[2], n));
  }
}

}  // namespace
}  // namespace palpate
