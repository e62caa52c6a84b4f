#include "tests/support/triangle_overlap.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

Triangle Moved(const Triangle& t, const Pose& X, double scale = 1.0) {
  return {X * (scale * t[0]), X * (scale * t[1]), X * (scale * t[2])};
}

using Whole = __int128;
struct WholePoint {
  Whole x, y, z;
};
WholePoint operator-(const WholePoint& a, const WholePoint& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Whole Dot(const WholePoint& a, const WholePoint& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
WholePoint Cross(const WholePoint& a, const WholePoint& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
bool Zero(const WholePoint& a) {
  return a.x == 0 && a.y == 0 && a.z == 0;
}

/// Two triangles meet if the origin is in the hull of the nine differences of their corners, and
/// then (Caratheodory) in a simplex of at most four of them.  Slow, and shares no code with Meet.
bool MeetByDifferences(const std::array<WholePoint, 3>& a, const std::array<WholePoint, 3>& b) {
  std::vector<WholePoint> d;
  for (const WholePoint& p : a) {
    for (const WholePoint& q : b) d.push_back(p - q);
  }
  for (std::size_t i = 0; i < 9; ++i) {
    if (Zero(d[i])) return true;
    for (std::size_t j = i + 1; j < 9; ++j) {
      if (Zero(Cross(d[i], d[j])) && Dot(d[i], d[j]) < 0) return true;
      for (std::size_t k = j + 1; k < 9; ++k) {
        const WholePoint n = Cross(d[j] - d[i], d[k] - d[i]);
        if (!Zero(n) && Dot(n, d[i]) == 0 && Dot(n, Cross(d[i], d[j])) >= 0 &&
            Dot(n, Cross(d[j], d[k])) >= 0 && Dot(n, Cross(d[k], d[i])) >= 0) {
          return true;
        }
        for (std::size_t l = k + 1; l < 9; ++l) {
          const Whole volume = Dot(n, d[l] - d[i]);
          if (volume == 0) continue;
          // With the origin in place of each corner in turn, all volumes have one sign.
          const Whole parts[4] = {Dot(Cross(d[j], d[k]), d[l]), -Dot(Cross(d[k], d[l]), d[i]),
                                  Dot(Cross(d[l], d[i]), d[j]), -Dot(Cross(d[i], d[j]), d[k])};
          bool inside = true;
          for (const Whole part : parts) inside &= volume > 0 ? part >= 0 : part <= 0;
          if (inside) return true;
        }
      }
    }
  }
  return false;
}

TEST(TriangleOverlap, AgreesWithWholeNumbersOnEveryKindOfTriangle) {
  int meet = 0, degenerate = 0, cases = 0;
  for (std::uint64_t seed = 0; seed < 60000; ++seed) {
    Random random(seed);
    // From grids so coarse that touching, coplanar and degenerate cases are common, to fine ones.
    const int half = seed % 4 == 0 ? 1 : seed % 4 == 1 ? 2 : seed % 4 == 2 ? 6 : 1 << 20;
    const auto grid = [&] { return Whole(random.Below(2 * half + 1) - half); };
    const bool in_plane = seed % 5 == 0;
    std::array<WholePoint, 3> a, b;
    for (auto* t : {&a, &b}) {
      for (WholePoint& p : *t) {
        p = {grid(), grid(), grid()};
        // A plane oblique to all axes.
        if (in_plane) p.z = p.x - 2 * p.y + 3;
      }
    }
    if (seed % 3 == 0) {
      b[0] = {(a[0].x + a[1].x) / 2, (a[0].y + a[1].y) / 2, (a[0].z + a[1].z) / 2};
    }
    if (seed % 7 == 0) {
      // A needle: the third corner beside the midpoint of the others.
      a[2] = {(a[0].x + a[1].x) / 2, (a[0].y + a[1].y) / 2, (a[0].z + a[1].z) / 2 + seed % 2};
    }
    // Powers of two keep the numbers exact: sizes of 1e-3 m and 10 m, sometimes far off the origin.
    const double step = seed % 2 == 0 ? 0x1.0p-30 : 0x1.0p-17;
    const double offset = seed % 11 == 0 ? 4096.0 : 0.0;
    const auto real = [&](const std::array<WholePoint, 3>& t) {
      Triangle out;
      for (std::size_t i = 0; i < 3; ++i) {
        out[i] = Vec3(static_cast<double>(t[i].x), static_cast<double>(t[i].y),
                      static_cast<double>(t[i].z)) *
                     step +
                 Vec3::Constant(offset);
      }
      return out;
    };
    const bool truth = MeetByDifferences(a, b);
    ASSERT_EQ(Meet(real(a), real(b)), truth) << "seed " << seed;
    ASSERT_EQ(Meet(real(b), real(a)), truth) << "seed " << seed;
    degenerate += Zero(Cross(a[1] - a[0], a[2] - a[0])) || Zero(Cross(b[1] - b[0], b[2] - b[0]));
    meet += truth;
    ++cases;
  }
  EXPECT_GT(meet, cases / 10);
  EXPECT_LT(meet, cases * 9 / 10);
  EXPECT_GT(degenerate, cases / 50);
}

TEST(TriangleOverlap, NoShorterWayThanItsDepthTakesThemApart) {
  int seen = 0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    Random random(seed);
    const auto triangle = [&] {
      return Triangle{random.InCube(1), random.InCube(1), random.InCube(1)};
    };
    const Triangle a = triangle(), b = triangle();
    if (!Meet(a, b)) continue;
    ++seen;
    const Separation out = ShortestSeparation(a, b);
    const auto apart_by = [&](const Vec3& way) { return !Meet(a, Moved(b, {way})); };
    EXPECT_TRUE(apart_by((out.depth + 1e-12) * out.axis)) << "seed " << seed;
    for (int i = 0; i < 40; ++i) {
      EXPECT_FALSE(apart_by(random.Uniform(0.0, 1.0 - 1e-9) * out.depth * random.Direction()))
          << "seed " << seed;
    }
    EXPECT_FALSE(apart_by((1.0 - 1e-9) * out.depth * out.axis)) << "seed " << seed;
  }
  EXPECT_GT(seen, 300);
}

TEST(TriangleOverlap, NearestPointsAreNoFurtherThanAnySamples) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Random random(seed);
    Triangle a{random.InCube(1), random.InCube(1), random.InCube(1)}, b = a;
    for (Vec3& p : b) p = random.InCube(1) + Vec3(1, 0, 0);
    if (seed % 5 == 0) b[2] = 0.5 * (b[0] + b[1]);
    const Nearest nearest = NearestPoints(a, b);
    if (Meet(a, b)) continue;
    EXPECT_NEAR((nearest.on_a - nearest.on_b).norm(), nearest.distance, 1e-15);
    double least = INFINITY;
    static constexpr int kSteps = 12;
    const auto at = [](const Triangle& t, int i, int k) {
      return Vec3(t[0] + (t[1] - t[0]) * i / kSteps + (t[2] - t[0]) * k / kSteps);
    };
    for (int i = 0; i <= kSteps; ++i) {
      for (int k = 0; i + k <= kSteps; ++k) {
        const Vec3 p = at(a, i, k);
        EXPECT_LE((NearestPoint(b, p) - p).norm(), (at(b, i, k) - p).norm() + 1e-15);
        least = std::min(least, (NearestPoint(b, p) - p).norm());
      }
    }
    EXPECT_LE(nearest.distance, least + 1e-15) << "seed " << seed;
    // The samples of a are at most 4 / kSteps apart.
    EXPECT_GE(nearest.distance, least - 4.0 / kSteps) << "seed " << seed;
  }
}

}  // namespace
}  // namespace palpate::test
