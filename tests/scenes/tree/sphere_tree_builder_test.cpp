#include "scenes/tree/sphere_tree_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/files/scene_bundle.h"
#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/surface_samples.h"
#include "scenes/tree/tree_error.h"
#include "tests/scenes/support.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::HasSubstr;

Vec3 Centre(const SphereTree& tree, std::size_t i) {
  return {tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]};
}

/// A bumpy ball, for which nothing was tuned.
TriangleMesh MakeBumpy(double radius) {
  TriangleMesh mesh = MakeSphere(radius, 5120);
  for (Vec3& v : mesh.vertices) {
    const Vec3 u = v / radius;
    v *= 1.0 + 0.08 * std::sin(7.0 * u.x()) * std::cos(5.0 * u.y() + 3.0 * u.z());
  }
  return mesh;
}

std::vector<std::uint8_t> BytesOf(const TriangleMesh& mesh, const SphereTree& tree) {
  Scene scene;
  scene.name = "s";
  scene.tools.push_back({"t", mesh, tree, {}});
  return PackScene(scene);
}

TEST(SphereTreeBuilder, GivesExactlyTheLeavesAskedFor) {
  const TriangleMesh mesh = MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 320);
  for (const std::size_t count : {1, 2, 7, 8, 9, 63, 64, 65, 512, 1000, 3076}) {
    EXPECT_EQ(BuildSphereTree(mesh, count).leaves(), count);
  }
}

TEST(SphereTreeBuilder, PutsEveryLeafInsideTheMesh) {
  for (const TriangleMesh& mesh :
       {MakeBox(Vec3(0.05, 0.05, 0.05)), MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 1280)}) {
    const SphereTree tree = BuildSphereTree(mesh, 512);
    const MeshQuery query(mesh);
    for (std::size_t i = 0; i < tree.leaves(); ++i) {
      EXPECT_TRUE(query.Inside(Centre(tree, i)));
      EXPECT_LE(tree.leaf_radius[i], query.Nearest(Centre(tree, i)).distance * (1 + 1e-12));
      EXPECT_GT(tree.leaf_radius[i], 0.0);
    }
  }
}

TEST(SphereTreeBuilder, LetsNearlyAllLeavesTouchTheSurface) {
  const TriangleMesh mesh = MakeBox(Vec3(0.05, 0.05, 0.05));
  const SphereTree tree = BuildSphereTree(mesh, 512);
  std::size_t touching = 0;
  for (std::size_t i = 0; i < tree.leaves(); ++i) {
    const Vec3 c = Centre(tree, i);
    touching += 0.025 - c.cwiseAbs().maxCoeff() - tree.leaf_radius[i] < 1e-9;  // analytic faces
  }
  EXPECT_GE(touching, 512 * 85 / 100);
}

TEST(SphereTreeBuilder, CoversTheSurfaceBetterWithMoreLeaves) {
  const TriangleMesh mesh = MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 5120);
  double last = 1.0;
  for (const std::size_t count : {64, 512, 4096}) {
    const Coverage coverage = MeasureCoverage(mesh, BuildSphereTree(mesh, count), 20000);
    // Tangent balls of spacing h and radius r leave h^2/8r: for r of 20 mm and h = 2 sqrt(A/N/3.5)
    // that is A/(7 N r), halved on average; three times that is allowed.
    EXPECT_LT(coverage.uncovered.mean, 3.0 * 0.5 * 0.0125 / (7.0 * double(count) * 0.02) + 2e-6);
    EXPECT_LT(coverage.uncovered.max, 10.0 * 0.0125 / (7.0 * double(count) * 0.02) + 10e-6);
    EXPECT_LT(coverage.uncovered.mean, last);
    last = coverage.uncovered.mean;
  }
}

TEST(SphereTreeBuilder, LeavesNoWayBetweenNeighbours) {
  // A ball of a tenth of the leaves' spacing must be stopped at the surface: rays from far away
  // towards the centre meet a leaf within 0.2 mm of it.
  const TriangleMesh mesh = MakeSphere(0.03, 5120);
  const SphereTree tree = BuildSphereTree(mesh, 2000);
  test::Numbers numbers;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 p = 0.0298 * numbers.Point(1).normalized();
    double nearest = 1.0;
    for (std::size_t i = 0; i < tree.leaves(); ++i) {
      nearest = std::min(nearest, (p - Centre(tree, i)).norm() - tree.leaf_radius[i]);
    }
    EXPECT_LT(nearest, 0.0);
  }
}

TEST(SphereTreeBuilder, FillsTheInside) {
  const TriangleMesh mesh = MakeBox(Vec3(0.1, 0.1, 0.1));
  const SphereTree tree = BuildSphereTree(mesh, 1000);
  test::Numbers numbers;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 p = numbers.Point(0.04);
    double nearest = 1.0;
    for (std::size_t i = 0; i < tree.leaves(); ++i) {
      nearest = std::min(nearest, (p - Centre(tree, i)).norm() - tree.leaf_radius[i]);
    }
    EXPECT_LT(nearest, 0.005) << p.transpose();
  }
}

TEST(SphereTreeBuilder, GivesEveryTriangleToTheLeafNearestToIt) {
  const TriangleMesh mesh = MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 1280);
  for (const std::size_t count : {1, 50, 1000}) {
    const SphereTree tree = BuildSphereTree(mesh, count);
    ASSERT_EQ(tree.leaf_triangle_begin.size(), count + 1);
    std::vector<std::set<std::uint32_t>> leaves_of(mesh.triangles.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      for (auto k = tree.leaf_triangle_begin[i]; k < tree.leaf_triangle_begin[i + 1]; ++k) {
        leaves_of[tree.leaf_triangle[k]].insert(i);
      }
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& [a, b, c] = mesh.triangles[t];
      const Vec3 middle = (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) / 3.0;
      double best = 1e300;
      double best_with = 1e300;  // over the leaves that list the triangle
      for (std::uint32_t i = 0; i < count; ++i) {
        const double d = (middle - Centre(tree, i)).norm() - tree.leaf_radius[i];
        best = std::min(best, d);
        if (leaves_of[t].contains(i)) best_with = std::min(best_with, d);
      }
      EXPECT_NEAR(best_with, best, 1e-15);
    }
  }
}

TEST(SphereTreeBuilder, GivesLargeTrianglesToAllLeavesThatTouchThem) {
  const SphereTree tree = BuildSphereTree(MakeBox(Vec3(1, 1, 1)), 512);  // 12 triangles
  std::size_t with = 0;
  for (std::size_t i = 0; i < tree.leaves(); ++i) {
    with += tree.leaf_triangle_begin[i + 1] > tree.leaf_triangle_begin[i];
  }
  EXPECT_GT(with, 512 * 90 / 100);
}

TEST(SphereTreeBuilder, GivesTheSameBytesAgain) {
  const TriangleMesh mesh = MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 1280);
  for (const TreeMode mode : {TreeMode::kInside, TreeMode::kBalanced}) {
    const auto bytes = [&] { return BytesOf(mesh, BuildSphereTree(mesh, 100, {}, mode)); };
    EXPECT_EQ(bytes(), bytes()) << NameOf(mode);
  }
}

/// Average height of the leaves over the surface as felt by a ball rolling over it, by brute force.
double MeanFelt(const TriangleMesh& mesh, const SphereTree& tree, double probe) {
  const auto centres = ScatterAbove(mesh, InspectMesh(mesh), MeshQuery(mesh), probe, 1009);
  double sum = 0.0;
  for (const SurfaceSample& s : centres) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < tree.leaves(); ++i) {
      const Vec3 c(tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]);
      nearest = std::min(nearest, (s.point - c).norm() - tree.leaf_radius[i]);
    }
    sum += probe - nearest;
  }
  return sum / double(centres.size());
}

TEST(SphereTreeBuilder, BalancesLeavesRoundTheSurface) {
  for (const TriangleMesh& mesh : {MakeBox(Vec3(0.05, 0.04, 0.03)),
                                   MakeEllipsoid(Vec3(0.05, 0.02, 0.03), 5120), MakeBumpy(0.03)}) {
    Body inside, balanced;
    inside.mesh = balanced.mesh = mesh;
    inside.tree = BuildSphereTree(mesh, 512);
    balanced.tree = BuildSphereTree(mesh, 512, {}, TreeMode::kBalanced);
    ASSERT_EQ(balanced.tree.leaves(), 512u);
    const UnionError before = MeasureLevels(mesh, inside.tree, 20011).back();
    const UnionError after = MeasureLevels(mesh, balanced.tree, 20011).back();
    EXPECT_LT(after.offset.rms, 0.8 * before.offset.rms);
    EXPECT_LT(after.tilt.rms, 1.02 * before.tilt.rms);
    // The leaves' spacing is 2 sqrt(area / (2 sqrt 3 * 0.8 * leaves)).
    const double spacing =
        2.0 * std::sqrt(InspectMesh(mesh).area / (2.0 * std::sqrt(3.0) * 0.8 * 512));
    EXPECT_LT(std::abs(MeanFelt(mesh, balanced.tree, 0.5 * spacing)),
              0.35 * std::abs(MeanFelt(mesh, inside.tree, 0.5 * spacing)));
    // 1/40 of the spacing, plus rounding.
    EXPECT_LT(after.protrusion.max, 0.026 * spacing);
  }
}

TEST(SphereTreeBuilder, MakesOfItsOwnLeavesTheSameTreeAgain) {
  const TriangleMesh mesh = MakeBumpy(0.03);
  const SphereTree built = BuildSphereTree(mesh, 100);
  const std::vector<Sphere> leaves = BallsByLevel(built).back();
  const SphereTree again = TreeOverBalls(mesh, leaves);
  ASSERT_EQ(again.leaves(), 100u);
  EXPECT_EQ(again.centroid, built.centroid);
  // The order of the leaves may differ; each one's triangles are the same.
  const auto shared = [](const SphereTree& tree) {
    std::set<std::tuple<double, double, double, std::vector<std::uint32_t>>> all;
    for (std::size_t i = 0; i < tree.leaves(); ++i) {
      const auto of = tree.leaf_triangle.begin();
      all.insert({tree.leaf_x[i],
                  tree.leaf_y[i],
                  tree.leaf_z[i],
                  {of + tree.leaf_triangle_begin[i], of + tree.leaf_triangle_begin[i + 1]}});
    }
    return all;
  };
  EXPECT_EQ(shared(again), shared(built));
  EXPECT_THAT(ComplaintOf([&] { TreeOverBalls(mesh, {}); }), HasSubstr("at least 1"));
}

TEST(SphereTreeBuilder, BalancesAFewLeavesToo) {
  const TriangleMesh mesh = MakeSphere(0.03, 1280);
  for (const std::size_t count : {1, 2, 9}) {
    const SphereTree tree = BuildSphereTree(mesh, count, {}, TreeMode::kBalanced);
    ASSERT_EQ(tree.leaves(), count);
    for (const double radius : tree.leaf_radius) EXPECT_GT(radius, 0.0);
  }
}

TEST(SphereTreeBuilder, GivesTheSameBytesInEveryBuild) {
  const TriangleMesh mesh = MakeBox(Vec3(0.05, 0.04, 0.03));
  const auto bytes = BytesOf(mesh, BuildSphereTree(mesh, 100));
  EXPECT_EQ(HashBytes({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, 0),
            0xb63d84b7ba8a4678u);
}

TEST(SphereTreeBuilder, TakesMeshesThatAreOpenDoubledOrPartlyDegenerate) {
  const TriangleMesh sphere = MakeSphere(0.03, 1280);
  TriangleMesh open = sphere;
  open.triangles.resize(1200);
  TriangleMesh doubled = sphere;
  doubled.triangles.insert(doubled.triangles.end(), sphere.triangles.begin(),
                           sphere.triangles.end());
  TriangleMesh degenerate = sphere;
  degenerate.triangles.push_back({0, 0, 1});
  for (const TriangleMesh& mesh : {open, doubled, degenerate}) {
    const SphereTree tree = BuildSphereTree(mesh, 300);
    ASSERT_EQ(tree.leaves(), 300u);
    for (std::size_t i = 0; i < tree.leaves(); ++i) {
      // Inside the sphere, except for what shows through the hole.
      EXPECT_LT(Centre(tree, i).norm() + tree.leaf_radius[i], 0.0305);
    }
  }
}

TEST(SphereTreeBuilder, TakesAFlatSheet) {
  TriangleMesh sheet;
  sheet.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 0, 1), Vec3(0, 0, 1)};
  sheet.triangles = {{0, 2, 1}, {0, 3, 2}};  // faces up (y)
  const SphereTree tree = BuildSphereTree(sheet, 200);
  EXPECT_EQ(tree.leaves(), 200u);
  for (std::size_t i = 0; i < tree.leaves(); ++i) {
    EXPECT_LT(tree.leaf_y[i] + tree.leaf_radius[i], 1e-9);
  }
}

TEST(SphereTreeBuilder, FitsAFewLargeBallsWhereOnlyTheMeshIsFelt) {
  TriangleMesh cup = MakeBox(Vec3::Constant(0.04));
  cup.triangles.resize(10);  // open on one side
  for (const TriangleMesh& mesh :
       {MakeBox(Vec3::Constant(0.04)), cup, MakeEllipsoid({0.03, 0.02, 0.0002}, 320)}) {
    const SphereTree tree = BuildInnerTree(mesh);
    ASSERT_GT(tree.leaves(), 0u);
    EXPECT_LE(tree.leaves(), kInnerLeaves);
    const MeshQuery query(mesh);
    for (std::size_t i = 0; i < tree.leaves(); ++i) {
      const Vec3 centre(tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]);
      EXPECT_GT(tree.leaf_radius[i], 0.0);
      EXPECT_LE(tree.leaf_radius[i], query.Nearest(centre).distance * (1.0 + 1e-9));
    }
    const std::set<std::uint32_t> triangles(tree.leaf_triangle.begin(), tree.leaf_triangle.end());
    EXPECT_EQ(triangles.size(), mesh.triangles.size());
  }
  // With eight cells of 5 mm per side, the central ones lie half a cell off the centre.
  EXPECT_NEAR(std::ranges::max(BuildInnerTree(MakeBox(Vec3::Constant(0.04))).leaf_radius), 0.0175,
              1e-9);
  EXPECT_THROW(BuildInnerTree({}), Error);
}

TEST(SphereTreeBuilder, KeepsTheSolidsCentroid) {
  TriangleMesh box = MakeBox(Vec3(0.1, 0.1, 0.1));
  for (Vec3& v : box.vertices) v += Vec3(0.3, 0, 0);
  EXPECT_NEAR((BuildSphereTree(box, 9).centroid - Vec3(0.3, 0, 0)).norm(), 0.0, 1e-12);
}

TEST(SphereTreeBuilder, MakesASphereToolOfOneExactLeaf) {
  const TriangleMesh mesh = MakeSphere(0.005, 320);
  const SphereTree tree = SingleSphereTree(mesh, {Vec3::Zero(), 0.005});
  ASSERT_EQ(tree.leaves(), 1u);
  EXPECT_EQ(tree.leaf_radius[0], 0.005);
  EXPECT_EQ(Centre(tree, 0), Vec3(0, 0, 0));
  EXPECT_GE(tree.packets[0].radius[0], 0.005);
  EXPECT_EQ(tree.leaf_triangle.size(), mesh.triangles.size());
}

TEST(SphereTreeBuilder, RefusesNoLeavesAndMeshesThatCannotBeRendered) {
  EXPECT_THAT(ComplaintOf([] { BuildSphereTree(MakeBox(Vec3(1, 1, 1)), 0); }),
              HasSubstr("ask for at least 1"));
  EXPECT_THAT(ComplaintOf([] { BuildSphereTree({}, 8); }), HasSubstr("no triangles"));
}

TEST(SphereTreeBuilder, TellsItsProgressInOrder) {
  double last = 0.0;
  BuildSphereTree(MakeBox(Vec3(1, 1, 1)), 600, [&](std::string_view stage, double fraction) {
    EXPECT_FALSE(stage.empty());
    EXPECT_GE(fraction, last);
    last = fraction;
  });
  EXPECT_EQ(last, 1.0);
}

}  // namespace
}  // namespace palpate
