#include "server/physics/surface/contact_bodies.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "tests/support/random.h"
#include "tests/support/test_scenes.h"

namespace palpate {
namespace {

using test::MakeBody;

PlacedTree Placed(const Body& body) {
  return {&body.tree, body.X_WB, &body.mesh, body.leaf_material, body.materials};
}

TEST(ContactBody, LeavesWhatYieldsToItsLeaves) {
  Body soft = MakeBody("soft", MakeBox(Vec3::Constant(0.02)), 64);
  soft.materials = {Material{.stiffness = 500.0}};
  Body partly = soft;
  partly.materials = {Material{}, Material{.stiffness = 500.0}};
  const Body rigid = MakeBody("rigid", MakeBox(Vec3::Constant(0.03)), 64);
  EXPECT_FALSE(TouchesByMesh(Placed(soft)));
  EXPECT_FALSE(TouchesByMesh(Placed(partly)));
  EXPECT_TRUE(TouchesByMesh(Placed(rigid)));
  const PlacedTree without[] = {Placed(soft), Placed(partly)};
  EXPECT_TRUE(MakeBodies(without).empty());
  const PlacedTree all[] = {Placed(soft), Placed(rigid), Placed(partly)};
  const auto bodies = MakeBodies(all);
  ASSERT_EQ(bodies.size(), 1u);
  EXPECT_EQ(bodies[0].shape->mesh.triangles().size(), rigid.mesh.triangles.size());
}

// A triangle takes its material from a leaf, which must be near and of the right body.
TEST(ContactBody, GivesEachTriangleTheLeafThatLiesAtIt) {
  const Body first = MakeBody("first", MakeBox(Vec3(0.02, 0.03, 0.04)), 64);
  const Body second =
      MakeBody("second", MakeSphere(0.01, 320), 128, {Vec3(0.1, 0.0, 0.0), Quat::Identity()});
  const PlacedTree both[] = {Placed(first), Placed(second)};
  const auto bodies = MakeBodies(both);
  const auto first_leaves = static_cast<std::int32_t>(first.tree.leaves());
  const auto of_first = static_cast<std::uint32_t>(first.mesh.triangles.size());
  const auto of_second = static_cast<std::uint32_t>(second.mesh.triangles.size());
  ASSERT_EQ(bodies.size(), 2u);
  for (std::uint32_t t = 0; t < of_first + of_second; ++t) {
    const Body& body = t < of_first ? first : second;
    const std::uint32_t own = t < of_first ? t : t - of_first;
    const ContactBody& made = bodies[t < of_first ? 0 : 1];
    const std::int32_t leaf = made.shape->leaf[own];
    ASSERT_EQ(made.first_leaf, t < of_first ? 0 : first_leaves);
    ASSERT_GE(leaf, 0);
    ASSERT_LT(leaf, static_cast<std::int32_t>(body.tree.leaves()));
    // A leaf that lists the triangle, and of those the nearest to its centroid.
    const auto distance = [&](std::size_t i) {
      Vec3 middle = Vec3::Zero();
      for (const std::uint32_t v : body.mesh.triangles[own]) {
        middle += body.mesh.vertices[v] / 3.0;
      }
      return (Vec3(body.tree.leaf_x[i], body.tree.leaf_y[i], body.tree.leaf_z[i]) - middle).norm() -
             body.tree.leaf_radius[i];
    };
    double least = 1e300;
    bool listed = false;
    for (std::size_t i = 0; i < body.tree.leaves(); ++i) {
      for (std::uint32_t k = body.tree.leaf_triangle_begin[i];
           k < body.tree.leaf_triangle_begin[i + 1]; ++k) {
        if (body.tree.leaf_triangle[k] != own) continue;
        least = std::min(least, distance(i));
        listed |= static_cast<std::int32_t>(i) == leaf;
      }
    }
    EXPECT_TRUE(listed) << "triangle " << t;
    EXPECT_EQ(distance(static_cast<std::size_t>(leaf)), least) << "triangle " << t;
  }
}

TEST(ContactBody, SharesItsShapeWithBodiesOfTheSameMeshOnly) {
  const Body box = MakeBody("box", MakeBox(Vec3::Constant(0.02)), 64);
  Body moved = box;
  moved.X_WB = {Vec3(0.1, 0.0, 0.0), RotationBetween(Vec3::UnitX(), Vec3(1.0, 2.0, 3.0))};
  Body other = box;
  other.mesh.vertices[0].x() += 1e-9;
  Body other_leaves = box;
  other_leaves.tree.leaf_radius[0] += 1e-9;
  const PlacedTree all[] = {Placed(box), Placed(other), Placed(moved), Placed(other_leaves)};
  const auto bodies = MakeBodies(all);
  ASSERT_EQ(bodies.size(), 4u);
  EXPECT_EQ(bodies[0].shape, bodies[2].shape);
  EXPECT_NE(bodies[0].shape, bodies[1].shape);
  EXPECT_NE(bodies[0].shape, bodies[3].shape);
  EXPECT_EQ(bodies[0].shape->mesh.vertices().size(), 8u);
  EXPECT_EQ(bodies[2].X_BS.p, moved.X_WB.p);
  EXPECT_EQ(bodies[2].first_leaf, static_cast<std::int32_t>(2 * box.tree.leaves()));
}

TEST(ContactBody, NamesTheRemedyWhereAMeshIsMissing) {
  const Body body = MakeBody("body", MakeBox(Vec3::Constant(0.02)), 64);
  PlacedTree placed = Placed(body);
  placed.mesh = nullptr;
  try {
    MakeBodies(std::span(&placed, 1));
    FAIL();
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("spheres"), std::string::npos);
  }
  EXPECT_THROW(MakeMovingBody(nullptr, body.tree, Vec3::Zero()), std::exception);
}

TEST(ContactBody, TakesAToolOfOneLeafForABall) {
  Body ball = MakeBody("ball", MakeSphere(0.005, 320), 64);
  ball.tree = SingleSphereTree(ball.mesh, {Vec3(0.001, 0.0, 0.0), 0.005});
  const auto tool = MakeMovingBody(nullptr, ball.tree, Vec3(0.001, 0.0, 0.0));
  EXPECT_EQ(tool->radius, 0.005);
  EXPECT_EQ(tool->mesh.triangles().size(), 1u);
  const Body box = MakeBody("box", MakeBox(Vec3::Constant(0.02)), 64);
  const Vec3 reference(0.003, 0.0, 0.0);
  const auto other = MakeMovingBody(&box.mesh, box.tree, reference);
  EXPECT_EQ(other->radius, 0.0);
  EXPECT_EQ(other->mesh.triangles().size(), 12u);
  EXPECT_NEAR(other->mesh.reach(), (Vec3::Constant(0.01) + reference).norm(), 1e-15);
}

TEST(ContactShape, FindsTheFaceThatAPointLiesOver) {
  const ContactShape shape{ContactMesh(MakeSphere(0.01, 1280))};
  test::Random random(4);
  for (int i = 0; i < 2000; ++i) {
    const std::uint32_t t = random.Below(1280);
    const Vec3 a = shape.mesh.Corner(t, 0), b = shape.mesh.Corner(t, 1),
               c = shape.mesh.Corner(t, 2);
    const double u = random.Uniform(0.01, 0.98);
    const double v = random.Uniform(0.01, 0.99 - u), up = random.Uniform(-2e-6, 2e-6);
    const Vec3 n = shape.mesh.triangles()[t].normal, along = (b - a).normalized();
    const Vec3 p = a + u * (b - a) + v * (c - a) + up * n;
    EXPECT_TRUE(HasFaceAt(shape, p, n, 2e-6, 1e-9)) << t;
    EXPECT_TRUE(HasFaceAt(shape, p, -n, 2e-6, 1e-9)) << "from either side";
    EXPECT_TRUE(HasFaceAt(shape, p, (n + 0.9e-3 * along).normalized(), 2.1e-6, 1e-3)) << t;
    EXPECT_FALSE(HasFaceAt(shape, p, (n + 1.1e-3 * along).normalized(), 2.1e-6, 1e-3)) << t;
    EXPECT_FALSE(HasFaceAt(shape, p, n, 0.9 * std::abs(up), 1e-9)) << "too far";
    // Beyond an edge of the triangle lies another, which has another normal.
    const Vec3 beyond = a + 0.5 * (b - a) - 1e-7 * n.cross(b - a).normalized();
    EXPECT_FALSE(HasFaceAt(shape, beyond, n, 2e-6, 1e-3)) << t;
  }
}

}  // namespace
}  // namespace palpate
