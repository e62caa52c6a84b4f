#include "scenes/mesh/mesh_orient.h"

#include <gtest/gtest.h>

#include "scenes/mesh/mesh_report.h"
#include "tests/scenes/support.h"
#include "tests/support/dirty_mesh.h"

namespace palpate {
namespace {

using test::TurnTriangle;

TEST(OrientTriangles, LeavesAGoodMeshAlone) {
  TriangleMesh mesh = MakeSphere(1.0, 320);
  const auto before = mesh.triangles;
  EXPECT_EQ(OrientTriangles(mesh), 0u);
  EXPECT_EQ(mesh.triangles, before);
}

TEST(OrientTriangles, TurnsThoseThatFaceTheWrongWay) {
  TriangleMesh mesh = MakeSphere(1.0, 320);
  for (const std::size_t t : {0, 7, 8, 100, 319}) TurnTriangle(mesh, t);
  EXPECT_EQ(OrientTriangles(mesh), 5u);
  EXPECT_TRUE(InspectMesh(mesh).solid());
  EXPECT_GT(InspectMesh(mesh).volume, 0.0);
}

TEST(OrientTriangles, TurnsAMeshThatIsInsideOutEvenWhereMostOfItIs) {
  TriangleMesh mesh = MakeSphere(1.0, 320);
  for (std::size_t t = 0; t < 300; ++t) TurnTriangle(mesh, t);
  EXPECT_EQ(OrientTriangles(mesh), 300u);
  EXPECT_TRUE(InspectMesh(mesh).solid());
  EXPECT_GT(InspectMesh(mesh).volume, 0.0);
}

TEST(OrientTriangles, LetsTheMajorityDecideInAnOpenMesh) {
  TriangleMesh mesh = MakeSphere(1.0, 320);
  mesh.triangles.resize(200);
  const auto before = mesh.triangles;
  for (const std::size_t t : {3, 50, 51}) TurnTriangle(mesh, t);
  EXPECT_EQ(OrientTriangles(mesh), 3u);
  EXPECT_EQ(mesh.triangles, before);
}

TEST(OrientTriangles, EndsForAMoebiusStripAndForDegenerateTriangles) {
  TriangleMesh strip;  // of five triangles
  for (int i = 0; i < 5; ++i) strip.vertices.push_back(Vec3(i, i * i, i * i * i));
  for (std::uint32_t i = 0; i < 5; ++i) strip.triangles.push_back({i, (i + 1) % 5, (i + 2) % 5});
  strip.triangles.push_back({2, 2, 3});
  OrientTriangles(strip);
  EXPECT_FALSE(InspectMesh(strip).oriented());
}

/// Two boxes as one mesh; `turned` says which of them are inside out.
TriangleMesh TwoBoxes(const Vec3& size, const Vec3& other, const Vec3& at,
                      std::array<bool, 2> turned) {
  TriangleMesh both = test::Both(MakeBox(size), test::Moved(MakeBox(other), at));
  for (std::size_t t = 0; t < both.triangles.size(); ++t) {
    if (turned[t / 12]) TurnTriangle(both, t);
  }
  return both;
}

TEST(OrientTriangles, TurnsThePieceThatIsInsideOutAndNoOther) {
  const Vec3 one = Vec3::Ones(), two = Vec3::Constant(2.0), apart(5, 0, 0);
  for (const auto turned :
       {std::array{true, false}, std::array{false, true}, std::array{true, true}}) {
    TriangleMesh mesh = TwoBoxes(one, two, apart, turned);
    EXPECT_EQ(OrientTriangles(mesh), 12u * (turned[0] + turned[1]));
    EXPECT_NEAR(InspectMesh(mesh).volume, 9.0, 1e-12);
  }
}

TEST(OrientTriangles, KeepsCavitiesAndSolidsWithinThem) {
  const Vec3 one = Vec3::Ones(), three = Vec3::Constant(3.0);
  TriangleMesh hollow = TwoBoxes(three, one, Vec3::Zero(), {false, true});
  EXPECT_EQ(OrientTriangles(hollow), 0u);
  EXPECT_NEAR(InspectMesh(hollow).volume, 26.0, 1e-12);
  TriangleMesh outside_in = TwoBoxes(three, one, Vec3::Zero(), {true, false});
  EXPECT_EQ(OrientTriangles(outside_in), 24u);
  EXPECT_NEAR(InspectMesh(outside_in).volume, 26.0, 1e-12);
}

}  // namespace
}  // namespace palpate
