#include "scenes/mesh/mesh_report.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/support.h"
#include "tests/support/dirty_mesh.h"

namespace palpate {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(MeshReport, MeasuresABox) {
  TriangleMesh box = MakeBox(Vec3(1, 2, 3));
  for (Vec3& v : box.vertices) v += Vec3(10, 20, 30);
  const MeshReport r = InspectMesh(box);
  EXPECT_TRUE(r.solid());
  EXPECT_FALSE(r.inside_out());
  EXPECT_EQ(r.components, 1u);
  EXPECT_NEAR(r.volume, 6.0, 1e-12);
  EXPECT_NEAR(r.area, 22.0, 1e-12);
  EXPECT_NEAR((r.centroid - Vec3(10, 20, 30)).norm(), 0.0, 1e-12);
  EXPECT_EQ(r.box_min, Vec3(9.5, 19, 28.5));
  EXPECT_EQ(r.box_max, Vec3(10.5, 21, 31.5));
  EXPECT_THAT(r.refusal, IsEmpty());
  EXPECT_THAT(r.remarks, IsEmpty());
}

TEST(MeshReport, CountsTheEdgesOfAHole) {
  TriangleMesh box = MakeBox(Vec3(1, 1, 1));
  box.triangles.pop_back();
  const MeshReport r = InspectMesh(box);
  EXPECT_FALSE(r.closed());
  EXPECT_EQ(r.boundary_edges, 3u);
  EXPECT_THAT(r.refusal, IsEmpty());
  EXPECT_THAT(r.remarks, Contains(HasSubstr("3 edges are open")));
}

TEST(MeshReport, SeesATriangleThatFacesTheWrongWay) {
  TriangleMesh box = MakeBox(Vec3(1, 1, 1));
  std::swap(box.triangles[0][1], box.triangles[0][2]);
  const MeshReport r = InspectMesh(box);
  EXPECT_TRUE(r.closed());
  EXPECT_FALSE(r.oriented());
  EXPECT_EQ(r.inconsistent_edges, 3u);
}

TEST(MeshReport, SeesAMeshThatIsInsideOut) {
  TriangleMesh box = MakeBox(Vec3(1, 1, 1));
  box = test::TurnedOver(box);
  const MeshReport r = InspectMesh(box);
  EXPECT_TRUE(r.inside_out());
  EXPECT_THAT(r.remarks, Contains(HasSubstr("inside out")));
}

TEST(MeshReport, SeesAThirdTriangleAtAnEdge) {
  TriangleMesh box = MakeBox(Vec3(1, 1, 1));
  box.vertices.push_back(Vec3(3, 3, 3));
  box.triangles.push_back({box.triangles[0][0], box.triangles[0][1], 8});
  const MeshReport r = InspectMesh(box);
  EXPECT_EQ(r.non_manifold_edges, 1u);
  EXPECT_FALSE(r.manifold());
}

TEST(MeshReport, CountsDuplicatesDegeneratesUnusedVerticesAndPieces) {
  const TriangleMesh box = MakeBox(Vec3(1, 1, 1));
  TriangleMesh mesh = test::Both(box, test::Moved(box, Vec3(5, 0, 0)));
  mesh.vertices.push_back(Vec3(9, 9, 9));
  mesh.triangles.push_back({mesh.triangles[0][1], mesh.triangles[0][2], mesh.triangles[0][0]});
  mesh.triangles.push_back({3, 3, 5});
  const MeshReport r = InspectMesh(mesh);
  EXPECT_EQ(r.components, 2u);
  EXPECT_EQ(r.duplicate_triangles, 1u);
  EXPECT_EQ(r.degenerate_triangles, 1u);
  EXPECT_EQ(r.unused_vertices, 1u);
  EXPECT_THAT(r.refusal, IsEmpty());
}

TEST(MeshReport, RefusesOnlyWhatCannotBeRenderedAndSaysHowToMendIt) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  TriangleMesh none;
  none.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0)};
  EXPECT_THAT(InspectMesh(none).refusal, HasSubstr("no triangles; export surfaces"));
  TriangleMesh broken = MakeBox(Vec3(1, 1, 1));
  broken.vertices[3].y() = nan;
  EXPECT_THAT(InspectMesh(broken).refusal, HasSubstr("1 vertex is not finite"));
  TriangleMesh flat = MakeBox(Vec3(0, 0, 0));
  EXPECT_THAT(InspectMesh(flat).refusal, HasSubstr("no extent"));
  TriangleMesh line = MakeBox(Vec3(1, 0, 0));
  EXPECT_THAT(InspectMesh(line).refusal, HasSubstr("no extent"));
  TriangleMesh wild = MakeBox(Vec3(1, 1, 1));
  wild.triangles[0][0] = 99;
  EXPECT_THAT(InspectMesh(wild).refusal, HasSubstr("a vertex that does not exist"));
  EXPECT_THAT(InspectMesh(MakeBox(Vec3(1, 1, 0))).refusal, IsEmpty());
}

}  // namespace
}  // namespace palpate
