#include "scenes/tree/tree_alignment.h"

#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/mesh/mesh_import.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/tree/sph_file.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "tests/scenes/support.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::HasSubstr;

double DiagonalOf(const TriangleMesh& mesh) {
  const MeshReport report = InspectMesh(mesh);
  return (report.box_max - report.box_min).norm();
}

/// A tree's leaves as read back from a .sph file in millimetres that somebody has moved.
std::vector<Sphere> FromFile(const SphereTree& tree, const Vec3& moved) {
  SphTree sph = ParseSph(ToSph(SphOf(tree), 1e-3), "tree.sph", 1e-3);
  std::vector<Sphere> balls = BallsOfLevel(sph, sph.levels);
  for (Sphere& ball : balls) ball.centre += moved;
  return balls;
}

TriangleMesh MovedBy(const Vec3& shift, TriangleMesh mesh) {
  for (Vec3& v : mesh.vertices) v += shift;
  return mesh;
}

/// An ellipsoid with a dent, so that it has no plane of symmetry.
TriangleMesh MakeUneven() {
  TriangleMesh mesh = MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 1280);
  for (Vec3& v : mesh.vertices) {
    v *= 1.0 - 0.3 * std::exp(-(v - Vec3(0.03, 0.01, 0.01)).squaredNorm() / (0.015 * 0.015));
  }
  return mesh;
}

TEST(TreeAlignment, FindsATranslationThatTheFileHasLost) {
  test::Numbers numbers;
  for (const TriangleMesh& mesh : {MakeUneven(), MakeBox(Vec3(0.05, 0.04, 0.03))}) {
    const double diagonal = DiagonalOf(mesh);
    for (const TreeMode mode : {TreeMode::kInside, TreeMode::kBalanced, TreeMode::kCover}) {
      const SphereTree tree = BuildSphereTree(mesh, 600, {}, mode);
      for (int k = 0; k < 3; ++k) {
        const Vec3 moved = numbers.Point(diagonal);
        const TreeAlignment found = AlignBalls(mesh, FromFile(tree, moved));
        EXPECT_LT((found.shift + moved).norm(), 1e-3 * diagonal) << NameOf(mode);
        EXPECT_EQ(found.misfit, "");
      }
    }
  }
}

TEST(TreeAlignment, TakesTheCentreOfTheBoxExactly) {
  // As the toolkit does: the mesh is moved by its bounding box to the origin, and the tree stays.
  const Vec3 centre(0.07, -0.11, 0.3);
  const TriangleMesh about = MakeBox(Vec3(0.05, 0.04, 0.03));
  const TriangleMesh mesh = MovedBy(centre, about);
  for (const TreeMode mode : {TreeMode::kInside, TreeMode::kBalanced, TreeMode::kCover}) {
    const std::vector<Sphere> balls = FromFile(BuildSphereTree(about, 200, {}, mode), Vec3::Zero());
    const TreeAlignment found = AlignBalls(mesh, balls);
    EXPECT_FALSE(found.fitted) << NameOf(mode);
    EXPECT_LT((found.shift - centre).norm(), 1e-12) << NameOf(mode);
    EXPECT_EQ(AlignBalls(about, balls).shift, Vec3(Vec3::Zero())) << NameOf(mode);
  }
}

TEST(TreeAlignment, FindsTheBunny) {
  const std::string file = "/usr/share/glmark2/models/bunny.obj";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "install glmark2-data";
  TriangleMesh mesh = ImportMesh(file);
  PlaceMesh({.longest_side = 0.15}, mesh);
  const SphereTree tree = BuildSphereTree(mesh, 512);
  const Vec3 moved(0.31, -0.04, 0.02);
  const TreeAlignment found = AlignBalls(mesh, FromFile(tree, moved));
  EXPECT_LT((found.shift + moved).norm(), 1e-3 * DiagonalOf(mesh));
  EXPECT_GT(found.uncovered_share, 0.9);  // the balls lie inside
  EXPECT_GT(found.mean, 0.0);
  EXPECT_EQ(found.misfit, "");
}

TEST(TreeAlignment, LeavesBallsWhereTheyAreWhereItIsTold) {
  const TriangleMesh mesh = MakeBox(Vec3(0.05, 0.04, 0.03));
  const SphereTree tree = BuildSphereTree(mesh, 300);
  const TreeAlignment as_it_is = AlignBalls(mesh, FromFile(tree, Vec3(0.0004, 0, 0)), false);
  EXPECT_EQ(as_it_is.shift, Vec3(Vec3::Zero()));
  EXPECT_THAT(ComplaintOf([&] { AlignBalls(mesh, FromFile(tree, Vec3(0.1, 0, 0)), false); }),
              HasSubstr("drop \"align\""));
}

TEST(TreeAlignment, RefusesAnotherUnitAndSaysSo) {
  const TriangleMesh mesh = MakeUneven();
  const SphereTree tree = BuildSphereTree(mesh, 300);
  for (const double wrong : {1000.0, 10.0, 2.54, 1.0 / 2.54, 1e-3}) {
    std::vector<Sphere> balls = FromFile(tree, Vec3(0.01, 0, 0));
    for (Sphere& ball : balls) {
      ball.centre *= wrong;
      ball.radius *= wrong;
    }
    EXPECT_THAT(ComplaintOf([&] { AlignBalls(mesh, balls); }), HasSubstr("give the \"unit\""))
        << wrong;
  }
}

TEST(TreeAlignment, WarnsOfATreeOfAnotherMesh) {
  const TriangleMesh box = MakeBox(Vec3(0.05, 0.04, 0.03)), uneven = MakeUneven();
  const TriangleMesh ball = MakeSphere(0.035, 5120);
  const auto misfit = [](const TriangleMesh& mesh, const TriangleMesh& of) {
    std::string told;
    const std::vector<Sphere> balls = FromFile(BuildSphereTree(of, 512), Vec3(0.02, 0, 0));
    const std::string complaint = ComplaintOf([&] { told = AlignBalls(mesh, balls).misfit; });
    return complaint == "no complaint" ? told : complaint;
  };
  EXPECT_THAT(misfit(box, uneven), HasSubstr("another mesh"));
  EXPECT_THAT(misfit(uneven, box), HasSubstr("another mesh"));
  EXPECT_THAT(misfit(ball, uneven), HasSubstr("another mesh"));
  EXPECT_THAT(misfit(uneven, ball), HasSubstr("another mesh"));
  EXPECT_EQ(misfit(box, box), "");
  // Not even the same box one and a half times as large.
  EXPECT_NE(misfit(MakeBox(Vec3(0.075, 0.06, 0.045)), box), "");
}

TEST(TreeAlignment, FindsTheSameAgain) {
  const TriangleMesh mesh = MakeUneven();
  const std::vector<Sphere> balls = FromFile(BuildSphereTree(mesh, 100), Vec3(0.01, 0.02, 0.03));
  const TreeAlignment a = AlignBalls(mesh, balls), b = AlignBalls(mesh, balls);
  EXPECT_EQ(a.shift, b.shift);
  EXPECT_EQ(a.residual, b.residual);
}

}  // namespace
}  // namespace palpate
