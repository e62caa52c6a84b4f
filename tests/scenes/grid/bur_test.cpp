#include "scenes/grid/bur.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/grid/bur_sweep.h"
#include "tests/support/complaint.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using test::Random;
using testing::HasSubstr;

const Bur kBall = Bur::Ball(0.25e-3);
const Bur kFissure = Bur::Cylinder(0.5e-3, 3e-3, 0.05e-3);
const Bur kSharp = Bur::Cylinder(0.5e-3, 3e-3, 0.0);
const Bur kTaper = Bur::Cone(0.3e-3, 0.6e-3, 3e-3, 0.1e-3);
const Bur kInverted = Bur::Cone(0.6e-3, 0.3e-3, 1e-3, 0.0);
const double kWall[] = {0.65e-3, 0.95e-3, 1.9e-3, 0.05e-3};  // inner, outer, height, rounding
const Bur kTrephine(
    {{kWall[0], 0}, {kWall[1], 0}, {kWall[1], kWall[2]}, {kWall[0], kWall[2]}, {kWall[0], 0}},
    kWall[3]);
const Bur* const kAll[] = {&kBall, &kFissure, &kSharp, &kTaper, &kInverted, &kTrephine};

double DistanceOf(const Bur& bur, const Vec3& p) {
  Vec3 gradient;
  return bur.Distance(p, gradient);
}

TEST(Bur, BallIsASphere) {
  Random random(1);
  for (int n = 0; n < 1000; ++n) {
    const Vec3 p = random.InCube(1e-3);
    Vec3 gradient;
    EXPECT_NEAR(kBall.Distance(p, gradient), p.norm() - 0.25e-3, 1e-18);
    EXPECT_LT((gradient - p.normalized()).norm(), 1e-12);
  }
}

TEST(Bur, SharpCylinderHasTheDistanceOfACylinder) {
  Random random(2);
  for (int n = 0; n < 10000; ++n) {
    const Vec3 p = random.InCube(4e-3);
    const double side = std::hypot(p.x(), p.y()) - 0.5e-3;
    const double end = std::max(-p.z(), p.z() - 3e-3);
    const double outside = std::hypot(std::max(side, 0.0), std::max(end, 0.0));
    EXPECT_NEAR(DistanceOf(kSharp, p), outside > 0.0 ? outside : std::max(side, end), 1e-17);
  }
}

TEST(Bur, TrephineHasTheDistanceOfARoundedRectangleInTheHalfPlane) {
  Random random(7);
  const auto& [inner, outer, high, rounding] = kWall;
  for (int n = 0; n < 10000; ++n) {
    const Vec3 p = random.InCube(2.5e-3);
    const double rho = std::hypot(p.x(), p.y());
    const double side = std::max(inner - rho, rho - outer), end = std::max(-p.z(), p.z() - high);
    const double outside = std::hypot(std::max(side, 0.0), std::max(end, 0.0));
    const double truth = (outside > 0.0 ? outside : std::max(side, end)) - rounding;
    EXPECT_NEAR(DistanceOf(kTrephine, p), truth, 1e-17);
  }
  EXPECT_NEAR(kTrephine.half_width(), 0.2e-3, 1e-12);
}

// The samples represent the whole surface: in the bore, outside and on both rims.
TEST(Bur, TrephinesSamplesLieOnItAndHaveItsArea) {
  const auto& [inner, outer, high, rounding] = kWall;
  // Walls, rims and, by Pappus, four quarter circles with centroids 2/pi of the rounding away.
  const double area =
      2.0 * M_PI *
      (high * (inner - rounding + outer + rounding) + (outer - inner) * (outer + inner) +
       M_PI * rounding * (inner - M_2_PI * rounding + outer + M_2_PI * rounding));
  double all = 0.0;
  int in_bore = 0;
  for (const BurSample& sample : kTrephine.Samples(500)) {
    all += sample.area;
    Vec3 gradient;
    EXPECT_NEAR(kTrephine.Distance(sample.point, gradient), 0.0, 2e-7);
    EXPECT_GT(gradient.dot(sample.normal), 0.9999);
    in_bore += std::hypot(sample.point.x(), sample.point.y()) < inner - 0.5 * rounding;
  }
  EXPECT_NEAR(all / area, 1.0, 1e-3);
  EXPECT_GT(in_bore, 100);
}

TEST(Bur, ConeHasTheSlantOfItsRadii) {
  // Half way up the tapered one's side, whose slant is 0.3 in 2.8 mm, moved out by the rounding.
  const double slant = std::atan2(0.3, 2.8);
  const Vec3 on_side(0.35e-3 + 0.1e-3 * std::cos(slant), 0.0, 1.4e-3 - 0.1e-3 * std::sin(slant));
  Vec3 gradient;
  EXPECT_NEAR(kTaper.Distance(on_side, gradient), 0.0, 1e-12);
  EXPECT_NEAR(gradient.x(), std::cos(slant), 1e-9);
  EXPECT_NEAR(gradient.z(), -std::sin(slant), 1e-9);
}

// A signed distance changes by its gradient, and nowhere faster than the point moves.
TEST(Bur, GradientIsThatOfTheDistance) {
  Random random(3);
  for (const Bur* bur : kAll) {
    for (int n = 0; n < 2000; ++n) {
      const Vec3 p = random.InCube(2e-3), d = 1e-9 * random.Direction();
      Vec3 gradient, other;
      const double here = bur->Distance(p, gradient), there = bur->Distance(p + d, other);
      EXPECT_NEAR(gradient.norm(), 1.0, 1e-12);
      EXPECT_LE(std::abs(there - here), d.norm() * (1.0 + 1e-6));
      if ((gradient - other).norm() < 1e-4) {
        EXPECT_NEAR(there - here, gradient.dot(d), 1e-4 * d.norm());
      }
    }
  }
}

/// Rounding of a sweep's distances to floats, within 3 mm of the bur [m].
constexpr double kFloats = 1e-9;

TEST(Bur, WayOfABallIsACapsule) {
  Random random(4);
  for (int n = 0; n < 20000; ++n) {
    const Vec3 p = random.InCube(0.5e-3), step = random.Uniform(0.0, 0.15e-3) * random.Direction();
    const double t = std::clamp(p.dot(step) / std::max(step.squaredNorm(), 1e-300), 0.0, 1.0);
    const double truth = (p - t * step).norm() - 0.25e-3;
    const double distance = BurSweep(kBall, step).Distance(p);
    EXPECT_GE(distance, truth - kFloats);
    // Away from the centre, where slopes turn within the step and no bur's band reaches.
    if (truth > -0.1e-3) {
      EXPECT_LE(distance, truth + 1e-4 * step.norm() + kFloats);
    }
  }
}

TEST(Bur, WayIsTheNearestOfManyPlacesOnIt) {
  Random random(5);
  for (const Bur* bur : kAll) {
    for (int n = 0; n < 2000; ++n) {
      const Vec3 p = random.InCube(1e-3);
      const Vec3 step = random.Uniform(0.0, 0.1e-3) * random.Direction();
      double truth = 1e300;
      for (int i = 0; i <= 200; ++i)
        truth = std::min(truth, DistanceOf(*bur, p - i / 200.0 * step));
      const double distance = BurSweep(*bur, step).Distance(p);
      EXPECT_LE(distance, std::min(DistanceOf(*bur, p), DistanceOf(*bur, p - step)) + kFloats);
      if (truth > -0.1e-3) {
        EXPECT_NEAR(distance, truth, 0.05 * step.norm());
      }
    }
  }
}

// Recordings are verified on other processors, so every instruction set must give the same bits.
TEST(Bur, RaisesARowToTheSameBitsByWhateverInstructions) {
  if (!BurSweep::IsWide()) GTEST_SKIP() << "there is one kind only";
  Random random(6);
  const float band = 0.2e-3f;
  for (const Bur* bur : kAll) {
    for (int n = 0; n < 5000; ++n) {
      const Vec3 step = random.Uniform(0.0, 0.1e-3) * random.Direction();
      const BurSweep sweep(*bur, step);
      const Vec3 first = random.InCube(1.5e-3), apart = 50e-6 * random.Direction();
      std::array<float, 8> phi;
      for (float& value : phi) value = static_cast<float>(random.Uniform(-0.25e-3, 0.25e-3));
      std::array<float, 8> narrow = phi, wide = phi;
      const BurSweep::Raised one = sweep.Raise(first, apart, band, narrow.data(), false);
      const BurSweep::Raised other = sweep.Raise(first, apart, band, wide.data(), true);
      ASSERT_EQ(narrow, wide);
      ASSERT_EQ(one.any, other.any);
      ASSERT_EQ(one.room, other.room);
      for (std::size_t i = 0; i < 8; ++i) {
        const double distance = sweep.Distance(first + double(i) * apart);
        const float truth = std::min(std::max(static_cast<float>(-distance), phi[i]), band);
        ASSERT_NEAR(narrow[i], truth, kFloats);
        const double end = DistanceOf(*bur, first + double(i) * apart - step);
        ASSERT_LE(one.room, narrow[i] < band ? end + narrow[i] + kFloats : 1e18);
      }
    }
  }
}

struct Whole {
  const Bur* bur;
  double area;
};

TEST(Bur, SamplesHaveTheSurfacesAreaAndEnclose) {
  const double r = 0.25e-3;
  for (const auto& [bur, area] :
       {Whole{&kBall, 4.0 * M_PI * r * r}, Whole{&kSharp, 2.0 * M_PI * 0.5e-3 * (3e-3 + 0.5e-3)},
        Whole{&kInverted, M_PI * (0.36e-6 + 0.09e-6 + 0.9e-3 * std::hypot(0.3e-3, 1e-3))}}) {
    for (const int count : {64, 256, 1024}) {
      const std::vector<BurSample> samples = bur->Samples(count);
      ASSERT_EQ(samples.size(), std::size_t(count));
      double sum = 0.0;
      Vec3 closed = Vec3::Zero();
      for (const BurSample& s : samples) {
        sum += s.area;
        closed += s.area * s.normal;
        Vec3 gradient;
        EXPECT_NEAR(bur->Distance(s.point, gradient), 0.0, 1e-12);
        EXPECT_NEAR(s.normal.norm(), 1.0, 1e-12);
        EXPECT_LE(bur->Distance(s.point - 1e-9 * s.normal, gradient), 0.0);
      }
      EXPECT_NEAR(sum / area, 1.0, 1e-4);
      EXPECT_LT(closed.norm() / area, 2.0 / count);  // zero for a closed surface
    }
  }
}

TEST(Bur, BadShapesAreRefusedWithAReason) {
  EXPECT_THAT(ComplaintOf([] { Bur::Ball(0.0); }), HasSubstr("give one above 0"));
  EXPECT_THAT(ComplaintOf([] { Bur::Ball(std::nan("")); }), HasSubstr("radius"));
  EXPECT_THAT(ComplaintOf([] { Bur::Cylinder(0.5e-3, 3e-3, 0.6e-3); }), HasSubstr("0.5 mm"));
  EXPECT_THAT(ComplaintOf([] {
                Bur({{0, 0}, {1e-3, 1e-3}, {0.1e-3, 1.2e-3}, {0, 5e-3}}, 0.0);
              }),
              HasSubstr("not convex at point 2"));
  EXPECT_THAT(ComplaintOf([] { Bur({{0, 0}, {1e-3, 1e-3}}, 0.0); }), HasSubstr("on the axis"));
  EXPECT_THAT(ComplaintOf([] { kBall.Samples(0); }), HasSubstr("at least 1"));
}

}  // namespace
}  // namespace palpate
