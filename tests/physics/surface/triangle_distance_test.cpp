#include "server/physics/surface/triangle_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/optimised.h"
#include "tests/support/random.h"
#include "tests/support/triangle_overlap.h"

namespace palpate {
namespace {

using test::Random;
using test::Triangle;

double Size(const Triangle& a, const Triangle& b) {
  double size = 0.0;
  for (const Vec3& x : a) size = std::max(size, x.cwiseAbs().maxCoeff());
  for (const Vec3& x : b) size = std::max(size, x.cwiseAbs().maxCoeff());
  return size;
}

/// Whether p lies, to within `error`, at the named corner, inside the named edge or in the face.
::testing::AssertionResult LiesIn(const Triangle& t, Feature of, const Vec3& p, double error) {
  const std::size_t i = of.index;
  if (of.kind != Feature::kFace && i > 2) return ::testing::AssertionFailure() << "no such index";
  if (of.kind == Feature::kVertex) {
    if ((p - t[i]).norm() <= error) return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure() << "not at corner " << i;
  }
  if (of.kind == Feature::kEdge) {
    const Vec3 e = t[(i + 1) % 3] - t[i];
    const double s = e.dot(p - t[i]) / e.squaredNorm();
    if (!(s > -error / e.norm() && s < 1.0 + error / e.norm())) {
      return ::testing::AssertionFailure() << "beyond the ends of edge " << i;
    }
    if ((t[i] + s * e - p).norm() <= error) return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure() << "beside edge " << i;
  }
  if ((test::NearestPoint(t, p) - p).norm() <= error) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "not in the face";
}

/// Proves independently that no two points are nearer: the plane perpendicular to p - q has all of
/// a on one side and all of b on the other, |p - q| apart.
double ProvenDistance(const Triangle& a, const Triangle& b, const Vec3& u) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec3& x : a) low = std::min(low, u.dot(x - a[0]));
  for (const Vec3& x : b) high = std::max(high, u.dot(x - a[0]));
  return low - high;
}

void Judge(const Triangle& a, const Triangle& b) {
  const NearestPoints got = NearestOfTriangles(a.data(), b.data());
  const double size = Size(a, b), distance = (got.p - got.q).norm();
  ASSERT_TRUE(std::isfinite(distance));
  EXPECT_NEAR(std::sqrt(got.squared), distance, 1e-12 * size);
  // For needles, to within 1e-9 of their size.
  EXPECT_TRUE(LiesIn(a, got.of_p, got.p, 1e-9 * size));
  EXPECT_TRUE(LiesIn(b, got.of_q, got.q, 1e-9 * size));
  if (!(distance > 1e-7 * size)) return;
  // The direction between points `distance` apart is off by 1e-15 size / distance, which shifts a
  // plane by `size` times that at the far corners.
  EXPECT_GE(ProvenDistance(a, b, (got.p - got.q) / distance),
            distance - 1e-14 * size * size / distance - 1e-12 * size);
}

Triangle RandomTriangle(Random& random, double size, const Vec3& at) {
  return {at + random.InCube(size), at + random.InCube(size), at + random.InCube(size)};
}

TEST(TriangleDistance, FindsTheNearestPointsOfAnyTwoTriangles) {
  for (const double size : {1e-3, 0.1, 10.0}) {
    Random random(21);
    int apart = 0;
    for (int candidate = 0; candidate < (test::kOptimised ? 20000 : 2000); ++candidate) {
      const Triangle a = RandomTriangle(random, size, Vec3::Zero());
      const Triangle b = RandomTriangle(random, size, random.InCube(1.5 * size));
      if (test::Meet(a, b)) continue;
      ++apart;
      SCOPED_TRACE(testing::Message() << "size " << size << ", candidate " << candidate);
      Judge(a, b);
      if (HasFailure()) return;
    }
    EXPECT_GT(apart, 1000);
  }
}

/// Corners, edges and faces lie in one another's planes, above or beside each other, because
/// coordinates are on a coarse grid.
TEST(TriangleDistance, FindsThemWhereEdgesAndFacesAreParallel) {
  Random random(22);
  const auto corner = [&] {
    return Vec3(0.01 * random.Below(4), 0.01 * random.Below(4), 0.01 * random.Below(2));
  };
  int apart = 0;
  for (int candidate = 0; candidate < (test::kOptimised ? 40000 : 4000); ++candidate) {
    const Vec3 up(0.0, 0.0, 1e-6 * random.Below(3) + 0.01 * random.Below(2));
    const Triangle a{corner() + up, corner() + up, corner() + up}, b{corner(), corner(), corner()};
    if (test::Meet(a, b)) continue;
    ++apart;
    SCOPED_TRACE(testing::Message() << "candidate " << candidate);
    Judge(a, b);
    if (HasFailure()) return;
  }
  EXPECT_GT(apart, 1000);
}

TEST(TriangleDistance, FindsThemOfTrianglesThatAreEdgesOrPoints) {
  Random random(23);
  for (int candidate = 0; candidate < (test::kOptimised ? 20000 : 2000); ++candidate) {
    Triangle a = RandomTriangle(random, 0.01, Vec3::Zero());
    Triangle b = RandomTriangle(random, 0.01, random.InCube(0.02));
    // Unspoilt; two equal corners; collinear; a single point.
    const auto spoil = [&](Triangle& t, int how) {
      const auto i = static_cast<std::size_t>(random.Below(3));
      if (how == 1) t[i] = t[(i + 1) % 3];
      if (how == 2) t[i] = 0.5 * (t[(i + 1) % 3] + t[(i + 2) % 3]);
      if (how == 3) t[1] = t[2] = t[0];
    };
    spoil(a, candidate % 4);
    spoil(b, candidate / 4 % 4);
    if (test::Meet(a, b)) continue;
    SCOPED_TRACE(testing::Message() << "candidate " << candidate);
    Judge(a, b);
    if (HasFailure()) return;
  }
}

TEST(TriangleDistance, FindsThemOfNeedles) {
  Random random(24);
  for (int candidate = 0; candidate < (test::kOptimised ? 20000 : 2000); ++candidate) {
    const auto needle = [&](const Vec3& at) {
      const double width = std::pow(10.0, random.Uniform(-9.0, -2.0));
      const Vec3 along = 0.05 * random.Direction();
      const Vec3 foot = at - random.Uniform(0.0, 1.0) * along;
      return Triangle{foot, foot + along, foot + 0.5 * along + width * random.Direction()};
    };
    const Triangle a = needle(Vec3::Zero()), b = needle(random.InCube(0.02));
    if (test::Meet(a, b)) continue;
    SCOPED_TRACE(testing::Message() << "candidate " << candidate);
    Judge(a, b);
    if (HasFailure()) return;
  }
}

TEST(TriangleDistance, NamesTheFeaturesThatAreNearest) {
  struct Case {
    Triangle a;
    Feature::Kind of_p;
    int index_p;
    Feature::Kind of_q;
    int index_q;
    double distance;
  };
  const Triangle b{Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(0, 3, 0)};
  const Case cases[] = {
      // A corner over the face, and the face over a corner.
      {{Vec3(1, 1, 3), Vec3(1, 1, 2), Vec3(2, 2, 4)}, Feature::kVertex, 1, Feature::kFace, 0, 2.0},
      {{Vec3(-5, -3, -3), Vec3(-5, 6, -3), Vec3(-5, 0, 6)},
       Feature::kFace,
       0,
       Feature::kVertex,
       0,
       5.0},
      // Corner to corner, corner to edge, crossing edges.
      {{Vec3(5, 0, 0), Vec3(7, 1, 0), Vec3(7, -1, 1)},
       Feature::kVertex,
       0,
       Feature::kVertex,
       1,
       2.0},
      {{Vec3(1, -1, 0), Vec3(0, -2, 1), Vec3(2, -2, -1)},
       Feature::kVertex,
       0,
       Feature::kEdge,
       0,
       1.0},
      {{Vec3(1, -1, -1), Vec3(1, -3, 0), Vec3(1, -1, 2)},
       Feature::kEdge,
       2,
       Feature::kEdge,
       0,
       1.0},
  };
  for (const Case& c : cases) {
    const NearestPoints got = NearestOfTriangles(c.a.data(), b.data());
    EXPECT_EQ(got.of_p.kind, c.of_p);
    EXPECT_EQ(got.of_p.index, c.index_p);
    EXPECT_EQ(got.of_q.kind, c.of_q);
    EXPECT_EQ(got.of_q.index, c.index_q);
    EXPECT_NEAR(std::sqrt(got.squared), c.distance, 1e-12);
  }
}

}  // namespace
}  // namespace palpate
