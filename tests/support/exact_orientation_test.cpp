#include "tests/support/exact_orientation.h"

#include <cstdint>

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace palpate::test {
namespace {

/// Points of a grid, so that the determinant is a whole number which __int128 holds.
struct GridPoint {
  __int128 x, y, z;
  /// Far from the origin on top of it: doubles hold the sum exactly, but not their products.
  Vec3 At(double step, double offset) const {
    return {step * static_cast<double>(x) + offset, step * static_cast<double>(y) + offset,
            step * static_cast<double>(z) + offset};
  }
};

GridPoint operator-(const GridPoint& a, const GridPoint& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

int Sign(__int128 x) {
  return (x > 0) - (x < 0);
}

TEST(ExactOrientation, IsTheSignOfWholeNumbersDeterminants) {
  Random random(1);
  int flat = 0;
  for (int i = 0; i < 200000; ++i) {
    const int half = i % 2 == 0 ? 3 : 1 << 20;
    const auto grid = [&] { return __int128(random.Below(2 * half + 1) - half); };
    GridPoint p[4];
    for (GridPoint& q : p) q = {grid(), grid(), grid()};
    if (i % 4 == 3) {
      // In the plane of the others, or one step of the grid beside it.
      p[3] = {p[0].x + p[1].x - p[2].x, p[0].y + p[1].y - p[2].y,
              p[0].z + p[1].z - p[2].z + random.Below(3) - 1};
    }
    const GridPoint a = p[0] - p[3], b = p[1] - p[3], c = p[2] - p[3];
    const int sign = Sign(a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) +
                          a.z * (b.x * c.y - b.y * c.x));
    const double step = 0x1.0p-30, offset = i % 3 == 0 ? 0.0 : 1024.0;
    Vec3 v[4];
    for (int k = 0; k < 4; ++k) v[k] = p[k].At(step, offset);
    ASSERT_EQ(Orient3d(v[0], v[1], v[2], v[3]), sign) << i;
    ASSERT_EQ(Orient3d(v[1], v[0], v[2], v[3]), -sign) << i;
    const GridPoint u = p[0] - p[2], w = p[1] - p[2];
    ASSERT_EQ(Orient2d(v[0], v[1], v[2], 0), Sign(u.y * w.z - u.z * w.y)) << i;
    ASSERT_EQ(Orient2d(v[0], v[1], v[2], 1), Sign(u.z * w.x - u.x * w.z)) << i;
    ASSERT_EQ(Orient2d(v[0], v[1], v[2], 2), Sign(u.x * w.y - u.y * w.x)) << i;
    flat += sign == 0;
  }
  EXPECT_GT(flat, 10000);
}

TEST(ExactOrientation, SeesOneUlpOffThePlane) {
  const Vec3 a(0.1, 0.1, 0.1), b(0.7, 0.2, 0.1), c(0.3, 0.9, 0.1);
  EXPECT_EQ(Orient3d(a, b, c, {0.4, 0.4, 0.1}), 0);
  EXPECT_EQ(Orient3d(a, b, c, {0.4, 0.4, std::nextafter(0.1, 0.0)}), 1) << "behind the normal";
  EXPECT_EQ(Orient3d(a, b, c, {0.4, 0.4, std::nextafter(0.1, 1.0)}), -1);
}

}  // namespace
}  // namespace palpate::test
