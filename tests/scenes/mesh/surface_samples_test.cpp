#include "scenes/mesh/surface_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "tests/scenes/support.h"
#include "tests/support/dirty_mesh.h"

namespace palpate {
namespace {

struct Surface {
  explicit Surface(TriangleMesh m) : mesh(std::move(m)), report(InspectMesh(mesh)), query(mesh) {}
  std::vector<SurfaceSample> Scatter(std::size_t count) const {
    return ScatterSamples(mesh, report, query, count);
  }
  TriangleMesh mesh;
  MeshReport report;
  MeshQuery query;
};

TEST(SurfaceSamples, LieOnTheSurfaceWithNormalsAwayFromTheSolid) {
  const Surface sphere(MakeSphere(1.0, 1280));
  const auto samples = sphere.Scatter(3000);
  ASSERT_EQ(samples.size(), 3000u);
  for (const SurfaceSample& s : samples) {
    EXPECT_LT(sphere.query.Nearest(s.point).distance, 1e-12);
    EXPECT_GT(s.outward.dot(s.point), 0.9);
  }
}

TEST(SurfaceSamples, AreAsManyAsTheAreaOfEachFace) {
  const Surface box(MakeBox(Vec3(1, 2, 4)));  // faces of 8, 4 and 2, each twice
  const auto samples = box.Scatter(2800);
  const auto on = [&](int axis) {
    return std::count_if(samples.begin(), samples.end(),
                         [&](const SurfaceSample& s) { return std::abs(s.outward[axis]) > 0.5; });
  };
  EXPECT_NEAR(on(0), 1600, 20);
  EXPECT_NEAR(on(1), 800, 20);
  EXPECT_NEAR(on(2), 400, 20);
}

TEST(SurfaceSamples, LeaveOutWallsInsideTheSolid) {
  TriangleMesh mesh = MakeSphere(1.0, 1280);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Vec3& v : {Vec3(-.3, 0, 0), Vec3(.3, 0, 0), Vec3(0, .4, 0)})
    mesh.vertices.push_back(v);
  mesh.triangles.push_back({first, first + 1, first + 2});
  for (const SurfaceSample& s : Surface(mesh).Scatter(2000)) EXPECT_GT(s.point.norm(), 0.9);
}

// The offset surface has faces, quarter cylinders at the edges, octants of a ball at the corners.
TEST(SamplesAbove, AreAsManyAsTheAreaThatABallsCentreRollsOver) {
  const Surface box(MakeBox(Vec3(1, 2, 4)));
  const double height = 0.5;
  const auto samples = ScatterAbove(box.mesh, box.report, box.query, height, 40000);
  ASSERT_NEAR(double(samples.size()), 40000.0, 2000.0);
  std::size_t faces = 0, edges = 0, corners = 0;
  for (const SurfaceSample& s : samples) {
    EXPECT_NEAR(box.query.Nearest(s.point).distance, height, 1e-6);
    // A millionth in front of another point is a thousandth beside it.
    EXPECT_LT((box.query.Nearest(s.point).point - (s.point - height * s.outward)).norm(), 2e-3);
    const long beyond = (s.point.array().abs() > Eigen::Array3d(0.5, 1, 2)).count();
    (beyond == 1 ? faces : beyond == 2 ? edges : corners) += 1;
  }
  const double over_faces = 28.0, over_edges = M_PI / 2.0 * height * 28.0,
               over_corners = 4.0 * M_PI * height * height;
  const double all = over_faces + over_edges + over_corners;
  EXPECT_NEAR(double(faces) / double(samples.size()), over_faces / all, 0.01);
  EXPECT_NEAR(double(edges) / double(samples.size()), over_edges / all, 0.01);
  EXPECT_NEAR(double(corners) / double(samples.size()), over_corners / all, 0.01);
}

TEST(SamplesAbove, AreEvenRoundAnEdge) {
  const Surface box(MakeBox(Vec3(1, 1, 40)));
  std::array<int, 6> sixths{};
  int all = 0;
  for (const SurfaceSample& s : ScatterAbove(box.mesh, box.report, box.query, 1.0, 60000)) {
    if (!(s.point.x() > 0.5 && s.point.y() > 0.5 && std::abs(s.point.z()) < 20.0)) continue;
    const double turned = std::atan2(s.point.y() - 0.5, s.point.x() - 0.5) / (M_PI / 2.0);
    ++sixths.at(std::min<std::size_t>(static_cast<std::size_t>(6.0 * turned), 5));
    ++all;
  }
  ASSERT_GT(all, 3000);
  for (const int count : sixths) EXPECT_NEAR(double(count) / all, 1.0 / 6.0, 0.02);
}

TEST(SamplesAbove, LeaveOutCreasesThatTheBallDoesNotReach) {
  // A post passes through a slab: its foot is surrounded by a crease, and there are walls inside.
  const Surface both(test::Both(MakeBox(Vec3(4, 4, 1)), MakeBox(Vec3(1, 1, 6))));
  const double height = 0.4;
  const auto samples = ScatterAbove(both.mesh, both.report, both.query, height, 5000);
  ASSERT_GT(samples.size(), 4000u);
  for (const SurfaceSample& s : samples) {
    EXPECT_GT(both.query.Nearest(s.point).distance, (1.0 - 2e-6) * height);
    EXPECT_FALSE(both.query.Inside(s.point));
    // Beside the post's foot a ball's centre keeps its distance from both.
    const bool beside_post = s.point.head<2>().cwiseAbs().maxCoeff() < 0.5 + 0.99 * height;
    EXPECT_FALSE(beside_post && std::abs(s.point.z()) < 0.5 + 0.99 * height);
  }
}

TEST(SamplesAbove, AreOfEverySideOfAFold) {
  TriangleMesh mesh = MakeSphere(1.0, 320);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Vec3& v : {Vec3(2, 0, 0), Vec3(3, 0, 0), Vec3(2, 1, 0)}) mesh.vertices.push_back(v);
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 1});
  const Surface fold(mesh);
  std::set<int> sides;
  for (const SurfaceSample& s : ScatterAbove(fold.mesh, fold.report, fold.query, 0.3, 5000)) {
    ASSERT_TRUE(s.point.allFinite());
    if (s.triangle + 2 >= mesh.triangles.size()) sides.insert(s.point.z() > 0.0 ? 1 : -1);
  }
  EXPECT_EQ(sides.size(), 2u);
}

TEST(ThinOut, KeepsExactlyAsManyAsAskedForAndFarApart) {
  const Surface sphere(MakeSphere(1.0, 5120));
  const auto samples = sphere.Scatter(5000);
  for (const std::size_t keep : {1u, 2u, 77u, 1000u, 5000u}) {
    const auto kept = ThinOut(samples, keep, sphere.report.area);
    ASSERT_EQ(kept.size(), keep);
    EXPECT_EQ(std::set<std::uint32_t>(kept.begin(), kept.end()).size(), keep);
  }
  const auto kept = ThinOut(samples, 1000, sphere.report.area);
  double nearest = 1e300;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      nearest = std::min(nearest, (samples[kept[i]].point - samples[kept[j]].point).norm());
    }
  }
  // Yuksel reports 0.7 of the largest possible distance; random sampling would give about 0.02.
  EXPECT_GT(nearest, 0.55 * 2 * PoissonRadius(sphere.report.area, 1000));
}

TEST(ThinOut, LetsTheTwoSidesOfAThinWallBe) {
  const Surface plate(MakeBox(Vec3(1, 1, 1e-4)));
  const auto samples = plate.Scatter(2000);
  const auto kept = ThinOut(samples, 400, plate.report.area);
  const auto top = std::count_if(kept.begin(), kept.end(),
                                 [&](std::uint32_t i) { return samples[i].outward.z() > 0.5; });
  EXPECT_NEAR(top, 200, 12);
}

}  // namespace
}  // namespace palpate
