#include "tests/support/flat_plates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

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

double LeastHeight(const TriangleMesh& mesh, std::size_t t) {
  double longest = 0.0;
  for (int k = 0; k < 3; ++k) {
    longest = std::max(longest, (Corner(mesh, t, (k + 1) % 3) - Corner(mesh, t, k)).norm());
  }
  return 2.0 * Upward(mesh, t) / longest;
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
    if (tessellation == "t-junctions") return;
    EXPECT_TRUE(report.solid());
    EXPECT_NEAR(report.volume, 4.0 * kPlateHalf * kPlateHalf * kPlateThickness, 1e-15);
  });
}

TEST(FlatPlates, OfTJunctionsHaveVerticesExactlyWithinTheEdgesOfOthers) {
  const TriangleMesh plate = Welded(MakePlate("t-junctions", 1));
  EXPECT_FALSE(InspectMesh(plate).closed());
  // All open edges lie on lines of the coarse grid, on which what one side covers the other does.
  std::map<std::array<double, 2>, double> covered;  // by line: of x (0) or z (1), and where
  for (std::size_t t = 0; t < plate.triangles.size(); ++t) {
    if (!IsTop(plate, t)) continue;
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = Corner(plate, t, k), b = Corner(plate, t, (k + 1) % 3);
      if (a.x() == b.x()) covered[{0.0, a.x()}] += b.z() - a.z();
      if (a.z() == b.z()) covered[{1.0, a.z()}] += b.x() - a.x();
    }
  }
  for (const auto& [line, length] : covered) {
    EXPECT_NEAR(std::abs(length), std::abs(line[1]) == kPlateHalf ? 2.0 * kPlateHalf : 0.0, 1e-15);
  }
}

TEST(FlatPlates, ReachFromNanometresToCentimetresAndNoFurther) {
  double least = INFINITY, most = 0.0;
  ForEachPlate([&](std::string_view, const TriangleMesh& plate) {
    for (std::size_t t = 0; t < plate.triangles.size(); ++t) {
      if (!IsTop(plate, t)) continue;
      least = std::min(least, LeastHeight(plate, t));
      most = std::max(most, LeastHeight(plate, t));
    }
  });
  EXPECT_GT(least, 1e-10);
  EXPECT_LT(least, 2e-9);
  EXPECT_GT(most, 0.01);
}

TEST(FlatPlates, OfDelaunayHaveNoCornerInTheCircleOfATriangle) {
  const TriangleMesh plate = MakePlate("delaunay", 2);
  for (std::size_t t = 0; t < plate.triangles.size(); ++t) {
    if (!IsTop(plate, t)) continue;
    const Vec3 a = Corner(plate, t, 0), b = Corner(plate, t, 1) - a, c = Corner(plate, t, 2) - a;
    const Vec3 n = b.cross(c);
    const Vec3 centre =
        a + (b.squaredNorm() * c.cross(n) + c.squaredNorm() * n.cross(b)) / (2.0 * n.squaredNorm());
    const double radius = (centre - a).norm();
    for (const Vec3& v : plate.vertices) {
      if (v.y() == 0.0) {
        ASSERT_GT((v - centre).norm(), radius * (1.0 - 1e-6));
      }
    }
  }
}

TEST(FlatPlates, AreMadeAnewFromTheirSeed) {
  for (const std::string_view tessellation : kTessellations) {
    const TriangleMesh once = MakePlate(tessellation, 7), again = MakePlate(tessellation, 7);
    EXPECT_EQ(once.vertices, again.vertices) << tessellation;
    EXPECT_EQ(once.triangles, again.triangles) << tessellation;
    if (tessellation != "quad") {
      EXPECT_NE(once.vertices, MakePlate(tessellation, 8).vertices) << tessellation;
    }
  }
}

}  // namespace
}  // namespace palpate::test
