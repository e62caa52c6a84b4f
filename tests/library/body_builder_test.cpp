#include "server/library/body_builder.h"

#include <limits>

#include <gmock/gmock.h>

#include "common/error.h"
#include "scenes/shapes/shapes.h"
#include "scenes/tree/leaf_count.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "tests/support/complaint.h"

namespace palpate::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

std::string Complaint(const TriangleMesh& mesh) {
  return ComplaintOf([&] { MakeBody("thing", mesh, {.leaves = 64}); });
}

TEST(BodyBuilder, TakesAsManyLeavesAsTheShapeNeedsWhereNobodySays) {
  const Body box = MakeBody("box", MakeBox({0.04, 0.04, 0.04}));
  const Body egg = MakeBody("egg", MakeSphere(0.02, 1280));
  const BodyOptions by_leaves{.contact = ContactModel::kSpheres};
  const Body sphere = MakeBody("sphere", MakeSphere(0.02, 1280), by_leaves);
  EXPECT_EQ(box.tree.leaves(), kInnerLeaves);
  EXPECT_GE(sphere.tree.leaves(), kFewestByTolerance);
  for (const Body* felt_by_mesh : {&box, &egg}) {
    EXPECT_GT(felt_by_mesh->tree.leaves(), 0u);
    EXPECT_LE(felt_by_mesh->tree.leaves(), kInnerLeaves);
  }
  EXPECT_EQ(MakeBody("box", MakeBox({0.04, 0.04, 0.04}), {.leaves = 200}).tree.leaves(), 200u);
  EXPECT_EQ(box.tree.origin, TreeOrigin::kInside);
  EXPECT_EQ(MakeBody("box", MakeBox({1, 1, 1}), {.leaves = 64, .contact = ContactModel::kSpheres})
                .tree.origin,
            TreeOrigin::kBalanced);
}

TEST(BodyBuilder, MendsWhatIsInsideOutAndSaysSo) {
  TriangleMesh mesh = MakeBox({0.04, 0.04, 0.04});
  for (auto& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
  const Body body = MakeBody("box", mesh, {.leaves = 64});
  ASSERT_EQ(body.remarks.size(), 1u);
  EXPECT_THAT(body.remarks[0], HasSubstr("inside out"));
  EXPECT_EQ(body.mesh.triangles.size(), mesh.triangles.size());
}

TEST(BodyBuilder, RefusesByNameWhatIsNoMesh) {
  EXPECT_THAT(Complaint({}), StartsWith("thing: "));
  TriangleMesh mesh = MakeBox({0.04, 0.04, 0.04});
  mesh.triangles[3][1] = 1'000'000;
  EXPECT_THAT(Complaint(mesh), StartsWith("thing: triangle 3 names vertex 1000000 of 8"));
  mesh = MakeBox({0.04, 0.04, 0.04});
  mesh.vertices[2].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Complaint(mesh), StartsWith("thing: vertex 2, from 0, is not finite"));
}

TEST(BodyBuilder, RemarksOnASizeThatIsHardlyInMetres) {
  const auto remarks = [](double size) {
    return MakeBody("thing", MakeBox(Vec3::Constant(size)), {.leaves = 64}).remarks;
  };
  EXPECT_TRUE(remarks(0.04).empty());
  ASSERT_EQ(remarks(40.0).size(), 1u);
  EXPECT_THAT(remarks(40.0)[0], AllOf(HasSubstr("40 m"), HasSubstr("more likely mm")));
  EXPECT_THAT(remarks(1e-9)[0], HasSubstr("hardly feels"));
  EXPECT_THAT(remarks(2e-4)[0], Not(HasSubstr("apart")));
  EXPECT_THAT(remarks(1e-5)[0], HasSubstr("0.001 mm apart"));
  ASSERT_EQ(MakeBall("ball", 5e-6).remarks.size(), 1u);
}

TEST(BodyBuilder, MakesABallOfOneExactLeaf) {
  const Body ball = MakeBall("ball", 0.005);
  ASSERT_EQ(ball.tree.leaves(), 1u);
  EXPECT_EQ(ball.tree.leaf_radius[0], 0.005);
  for (const double radius : {0.0, -1.0, std::numeric_limits<double>::infinity(),
                              std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(MakeBall("ball", radius), Error) << radius;
  }
}

}  // namespace
}  // namespace palpate::test
