#include "tests/support/folded_plates.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/dirty_mesh.h"
#include "tests/support/flat_plates.h"

namespace palpate::test {
namespace {

constexpr double kHalfAngle = 0.7;

std::vector<Vec3> Hexagon() {
  std::vector<Vec3> outline;
  for (int i = 0; i < 6; ++i) {
    outline.push_back(0.02 * Vec3(std::cos(M_PI / 3.0 * i), std::sin(M_PI / 3.0 * i), 0.0));
  }
  return outline;
}

/// Returns the area of all triangles that lie in a plane n . x = offset and face along n.
double AreaIn(const TriangleMesh& mesh, const Vec3& n, double offset) {
  double area = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = Corner(mesh, t, 0), b = Corner(mesh, t, 1), c = Corner(mesh, t, 2);
    const auto off = [&](const Vec3& v) { return std::abs(n.dot(v) - offset); };
    if (std::max({off(a), off(b), off(c)}) > 1e-16) continue;
    area += 0.5 * (b - a).cross(c - a).dot(n);
  }
  return area;
}

TEST(FoldedPlates, HaveSidesThatAreFlatFaceOutAndAreWhole) {
  for (const std::string_view tessellation : kTessellations) {
    SCOPED_TRACE(std::string(tessellation));
    const TriangleMesh groove = MakeGroove(tessellation, kHalfAngle, 1, 2);
    const double s = std::sin(kHalfAngle), c = std::cos(kHalfAngle);
    for (const double side : {-1.0, 1.0}) {
      EXPECT_NEAR(AreaIn(groove, Vec3(side * c, s, 0.0), 0.0), 4.0 * kPlateHalf * kPlateHalf, 1e-9);
    }
    const TriangleMesh hole = MakeHole(tessellation, Hexagon(), 1);
    for (int i = 0; i < 6; ++i) {
      const double angle = M_PI / 3.0 * (i + 0.5);
      const Vec3 inward(-std::cos(angle), -std::sin(angle), 0.0);
      EXPECT_NEAR(AreaIn(hole, inward, -0.02 * std::cos(M_PI / 6.0)), 0.02 * 2.0 * kPlateHalf,
                  1e-9);
    }
  }
}

TEST(FoldedPlates, AreClosedAndOfTheVolumeThatTheirSidesEnclose) {
  for (const std::string_view tessellation : kTessellations) {
    SCOPED_TRACE(std::string(tessellation));
    const auto expect = [](const TriangleMesh& mesh, double volume) {
      Vec3 areas = Vec3::Zero();
      double enclosed = 0.0;
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Vec3 a = Corner(mesh, t, 0), b = Corner(mesh, t, 1), c = Corner(mesh, t, 2);
        areas += 0.5 * (b - a).cross(c - a);
        enclosed += a.dot(b.cross(c)) / 6.0;
      }
      EXPECT_LT(areas.norm(), 1e-15);
      EXPECT_NEAR(enclosed, volume, 1e-6 * volume);
    };
    const double wide = 2.0 * kPlateHalf;
    expect(MakeGroove(tessellation, kHalfAngle, 1, 2),
           2.0 * wide * std::sin(kHalfAngle) * kPlateThickness * wide);
    const double hexagon = 1.5 * std::sqrt(3.0) * 0.02 * 0.02;
    expect(MakeHole(tessellation, Hexagon(), 1), (1.5 * 1.5 - 1.0) * hexagon * wide);
  }
}

}  // namespace
}  // namespace palpate::test
