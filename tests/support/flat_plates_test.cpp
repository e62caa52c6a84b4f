#include "tests/support/flat_plates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "scenes/mesh/mesh_report.h"
#include "tests/support/dirty_mesh.h"

namespace palpate::test {
namespace {

constexpr std::uint64_t kSeeds = 8;

/// Makes one vertex of all that coincide, bit for bit.
TriangleMesh Welded(const TriangleMesh& mesh) {
  TriangleMesh welded;
  std::map<std::array<double, 3>, std::uint32_t> known;
  const auto of = [&](std::uint32_t v) {
    const Vec3& p = mesh.vertices[v];
    const auto next = static_cast<std::uint32_t>(welded.vertices.size());
    const auto [at, made] = known.try_emplace({p.x(), p.y(), p.z()}, next);
    if (made) welded.vertices.push_back(p);
    return at->second;
  };
  for (const auto& [a, b, c] : mesh.triangles) welded.triangles.push_back({of(a), of(b), of(c)});
  return welded;
}

/// The y component of the triangle's area vector; on the top the area, if it faces up.
double Upward(const TriangleMesh& mesh, std::size_t t) {
  const Vec3 a = Corner(mesh, t, 0);
  return 0.5 * (Corner(mesh, t, 1) - a).cross(Corner(mesh, t, 2) - a).y();
}

bool IsTop(const TriangleMesh& mesh, std::size_t t) {
  return Corner(mesh, t, 0).y() == 0.0 && Corner(mesh, t, 1).y() == 0.0 &&
         Corner(mesh, t, 2).y() == 0.0;
}

template <class Check>
void ForEachPlate(Check check) {
  for (const std::string_view tessellation : kTessellations) {
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      SCOPED_TRACE(std::string(tessellation) + ", seed " + std::to_string(seed));
      check(tessellation, MakePlate(tessellation, seed));
    }
  }
}

TEST(FlatPlates, HaveATopWhoseTrianglesLieInItsPlaneFaceUpAndCoverIt) {
  ForEachPlate([](std::string_view, const TriangleMesh& plate) {
    for (const Vec3& v : plate.vertices) {
      ASSERT_TRUE(v.y() == 0.0 || v.y() == -kPlateThickness);
      ASSERT_LE(std::max(std::abs(v.x()), std::abs(v.z())), kPlateHalf);
    }
    double covered = 0.0;
    for (std::size_t t = 0; t < plate.triangles.size(); ++t) {
      if (!IsTop(plate, t)) continue;
      ASSERT_GT(Upward(plate, t), 0.0);
      covered += Upward(plate, t);
    }
    // Together with the areas above 0, no two triangles overlap.
    EXPECT_NEAR(covered, 4.0 * kPlateHalf * kPlateHalf, 1e-15);
  });
}

TEST(FlatPlates, AreClosedWhereTheirVerticesCoincide) {
  ForEachPlate([](std::string_view tessellation, const TriangleMesh& plate) {
    const MeshReport report = InspectMesh(Welded(plate));
    EXPECT_EQ(report.degenerate_triangles, 0u);
    EXPECT_EQ(report.refusal, "");
    EXPECT_EQ(report.closed(), tessellation != "t-junctions");
    if (!report.closed()) return;
    EXPECT_TRUE(report.solid());
    EXPECT_NEAR(report.volume, 4.0 * kPlateHalf * kPlateHalf * kPlateThickness, 1e-15);
  });
}

}  // namespace
}  // namespace palpate::test
