#include "tests/benchmarks/truth_folds.h"

#include <cmath>
#include <string_view>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "tests/benchmarks/figure_of.h"

namespace palpate::bench {
namespace {

using test::Random;
using test::Vec2;

/// Whether a point of the object's frame is within its material, by the winding number.
bool IsInside(const TriangleMesh& mesh, const Vec3& p) {
  double angle = 0.0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3 a = mesh.vertices[i] - p, b = mesh.vertices[j] - p, c = mesh.vertices[k] - p;
    const double an = a.norm(), bn = b.norm(), cn = c.norm();
    angle += 2.0 * std::atan2(a.dot(b.cross(c)),
                              an * bn * cn + a.dot(b) * cn + b.dot(c) * an + c.dot(a) * bn);
  }
  return angle > 2.0 * M_PI;
}

TEST(TruthFolds, LieInTheirBodiesAsThePlanesTruthSays) {
  for (const std::string_view tool : kFolded) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      SCOPED_TRACE(std::string(tool) + ", seed " + std::to_string(seed));
      Random random(seed);
      const Fold fold = MakeFold("quad", tool, false, random);
      // At rest, some corner of the tool is as near to the material as the separation, plus a
      // ball's radius, and 0.1 um farther towards the hand's side it is nearer.
      const test::PlanarRest rest = RestOf(fold.fit, {1e-3, -5e-3}, 0.0);
      ASSERT_FALSE(rest.holds.empty());
      const double ball = tool == "ball" ? fold.tool.tree.leaf_radius[0] : 0.0;
      for (const int side : rest.holds) {
        const Vec2 n = fold.fit.sides[static_cast<std::size_t>(side)].normal;
        double lowest = INFINITY;
        Vec2 corner;
        for (const Vec2& v : fold.fit.outline) {
          const Vec2 turned = Eigen::Rotation2Dd(rest.angle) * v;
          if (n.dot(turned) < lowest) lowest = n.dot(turned), corner = rest.at + turned;
        }
        const auto below = [&](double depth) {
          const Vec2 p = corner - (ball + depth) * n;
          return IsInside(fold.object.mesh, Vec3(p.x(), p.y(), 0.0003));
        };
        EXPECT_FALSE(below(0.9e-6));
        EXPECT_TRUE(below(1.1e-6));
      }
    }
  }
}

TEST(TruthFolds, SeeAWrongSplitAndAToolThatIsTooNear) {
  Random random(1);
  Fold fold = MakeFold("quad", "ball", false, random);
  Scene scene;
  scene.objects = {fold.object};
  const double bottom = RestOf(fold.fit, {0.0, -0.005}, 0.0).at.y();
  const FoldSample hand{{1e-4, bottom - 2e-3}, 0.0, 0.0};
  const test::PlanarRest rest = RestOf(fold.fit, hand.at, 0.0);
  ASSERT_EQ(rest.holds.size(), 2u);
  // The same sum of loads, or the same height, with the loads of both sides exchanged.
  const auto judged = [&](double one, double other, double lower) {
    FoldJudge judge(fold, scene, {hand});
    StepReport report;
    const Vec2 force = one * fold.fit.sides[static_cast<std::size_t>(rest.holds[0])].normal +
                       other * fold.fit.sides[static_cast<std::size_t>(rest.holds[1])].normal;
    report.wrench.force = Vec3(force.x(), force.y(), 0.0);
    report.X_WG.p = Vec3(rest.at.x(), rest.at.y() - lower, 0.0);
    judge.See(0, report);
    return judge;
  };
  const FoldJudge right = judged(rest.load[0], rest.load[1], 0.0);
  EXPECT_LT(FigureOf(right, "force off N"), 1e-9);
  EXPECT_LT(FigureOf(right, "out um"), 1e-6);
  EXPECT_GT(FigureOf(judged(rest.load[1], rest.load[0], 0.0), "force off N"), 0.1);
  EXPECT_GT(FigureOf(judged(rest.load[0], rest.load[1], 1e-6), "out um"), 0.4);
}

TEST(TruthFolds, SeeAPegThatTurnsTooEarly) {
  Random random(2);
  const Fold fold = MakeFold("quad", "peg", false, random);
  Scene scene;
  scene.objects = {fold.object};
  const FoldSample hand{Vec2::Zero(), 0.08, 0.01};
  const double stop = RestOf(fold.fit, hand.at, hand.angle).angle;
  ASSERT_GT(stop, 0.0);
  ASSERT_LT(stop, hand.angle);
  for (const double angle : {stop, 0.5 * stop}) {
    FoldJudge judge(fold, scene, {hand});
    StepReport report;
    report.X_WG = {-(RotationExp(angle * Vec3::UnitZ()) * fold.tool.tree.centroid),
                   RotationExp(angle * Vec3::UnitZ())};
    report.wrench.torque = fold.fit.torsional * (angle - hand.angle) * Vec3::UnitZ();
    judge.See(0, report);
    EXPECT_NEAR(FigureOf(judge, "torque N m"), stop - angle, 1e-9);
    EXPECT_LT(FigureOf(judge, "out um"), 1e-3);
  }
}

}  // namespace
}  // namespace palpate::bench
