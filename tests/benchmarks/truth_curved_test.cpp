#include "tests/benchmarks/truth_curved.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "tests/benchmarks/figure_of.h"
#include "tests/benchmarks/truth_judges.h"

namespace palpate::bench {
namespace {

using test::CurvedBody;
using test::Random;

constexpr double kSpring = 1000.0, kTurning = 1.0;

/// Returns the direction and size of the force on a plane, `height` below its centre, or on a ball
/// (whose turn costs nothing), on a convex mesh: what leaves the least energy, by trying tilts.
Vec3 ForceByTrying(const CurvedBody& body, const CurvedTool& tool, const CurvedBody::Point& on,
                   double depth) {
  const Vec3 centre = on.at + (tool.height - depth) * on.normal;
  const auto lift = [&](const Vec3& m) {
    double highest = -INFINITY;
    for (const Vec3& v : body.mesh().vertices) highest = std::max(highest, m.dot(v - centre));
    return highest + tool.height;
  };
  const auto energy = [&](const Vec3& tilt) {
    const double up = lift(RotationExp(tilt) * on.normal);
    const double turn = tool.is_ball ? 0.0 : kTurning * tilt.squaredNorm();
    return 0.5 * kSpring * up * up + 0.5 * turn;
  };
  const Vec3 x = on.normal.unitOrthogonal(), y = on.normal.cross(x);
  Vec3 best = Vec3::Zero();
  double least = energy(best);
  for (double step = 0.02; step > 1e-6; step *= 0.6) {
    for (int i = 0; i < 24; ++i) {
      const double angle = M_PI / 12.0 * i;
      const Vec3 tried = best + step * (std::cos(angle) * x + std::sin(angle) * y);
      if (const double e = energy(tried); e < least) least = e, best = tried;
    }
  }
  const Vec3 m = RotationExp(best) * on.normal;
  return kSpring * lift(m) * m;
}

TEST(TruthCurved, BoundsHoldForTheRestOnTheMeshThatTryingFinds) {
  double ball = 0.0, foot = 0.0;  // how near to its bound the worst direction comes
  for (const std::string_view kind : {"sphere", "ellipsoid"}) {
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      SCOPED_TRACE(std::string(kind) + ", seed " + std::to_string(seed));
      Random random(seed);
      const CurvedBody body(kind, 1000, random);
      Vec3 along;
      const CurvedBody::Point on = body.Start(true, along, random);
      const double depth = random.Uniform(1e-3, 3e-3);
      for (const bool is_ball : {false, true}) {
        const CurvedTool tool{is_ball, true, 0.004, kSpring, kTurning, 0.0};
        const CurvedBound bound = BoundOf(body, tool, depth);
        const Vec3 force = ForceByTrying(body, tool, on, depth);
        const double angle = std::atan2(force.cross(on.normal).norm(), force.dot(on.normal));
        EXPECT_LT(angle, bound.angle);
        double& ratio = is_ball ? ball : foot;
        ratio = std::max(ratio, angle / bound.angle);
        EXPECT_LT(std::abs(force.norm() - kSpring * depth), bound.size);
      }
    }
  }
  EXPECT_GT(ball, 0.5);
  EXPECT_GT(foot, 0.5);
}

TEST(TruthCurved, SeesADirectionASizeAndATorqueBeyondTheBounds) {
  const CurvedTool tool{false, true, 0.004, kSpring, kTurning, 0.0};
  const CurvedJudge::Sample sample{Vec3::UnitY(), 1e-3, {0.01, 0.05, 0.002}};
  const auto judged = [&](const Vec3& force, double torque) {
    CurvedJudge judge(tool, 1e-4, {sample});
    StepReport report;
    report.wrench = {force, torque * Vec3::UnitX()};
    judge.See(0, report);
    return judge;
  };
  const auto tilted = [](double by) { return Vec3(std::sin(by), std::cos(by), 0.0); };
  EXPECT_EQ(FigureOf(judged(Vec3::UnitY(), 0.0), "angle deg"), 0.0);
  const CurvedJudge within = judged(0.96 * tilted(0.009), 0.0019);
  EXPECT_EQ(FigureOf(within, "over"), 0.0);
  EXPECT_NEAR(FigureOf(within, "size off N"), 0.04, 1e-9);
  EXPECT_EQ(FigureOf(judged(tilted(0.02), 0.0), "over"), 1.0);
  EXPECT_GT(FigureOf(judged(tilted(0.02), 0.0), "its over deg"), 0.5);
  EXPECT_EQ(FigureOf(judged(0.9 * Vec3::UnitY(), 0.0), "over"), 1.0);
  EXPECT_EQ(FigureOf(judged(Vec3::UnitY(), 0.004), "over"), 1.0);
}

TEST(TruthCurved, KnowsFrictionFromTheLoadOfABallAndFromTheFootOfABox) {
  Random random(1);
  const auto body = std::make_shared<const CurvedBody>("sphere", 1000, random);
  Vec3 along;
  const CurvedBody::Point on = body->Start(true, along, random);
  for (const bool is_ball : {false, true}) {
    for (const double mu : {kTruthDynamic, 0.97 * kTruthDynamic}) {
      CurvedSlideJudge judge(body, {is_ball, true, 0.004, kSpring, kTurning, 0.0}, Pose(), 0.0, 0);
      StepReport report;
      report.X_WG = {on.at + 0.004 * on.normal, RotationBetween(Vec3::UnitY(), on.normal)};
      report.wrench.force = on.normal - mu * along;
      report.contacts = 1;
      report.active[0].normal = on.normal;
      report.active[0].force = 1.0;
      judge.See(0, report);
      EXPECT_NEAR(FigureOf(judge, "mu least"), mu, 1e-9);
      EXPECT_NEAR(FigureOf(judge, "mu most"), mu, 1e-9);
      EXPECT_EQ(FigureOf(judge, "1 % off"), mu == kTruthDynamic ? 0.0 : 1.0);
      EXPECT_NEAR(FigureOf(judge, "over deg"), 0.0, 1e-6);
      report.active[0].normal = RotationExp(0.01 * along) * on.normal;
      judge.See(0, report);
      EXPECT_NEAR(FigureOf(judge, "over deg"), is_ball ? 0.01 * 180.0 / M_PI : 0.0, 1e-6);
    }
  }
}

}  // namespace
}  // namespace palpate::bench
