#include "tests/benchmarks/truth_folds.h"

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "tests/benchmarks/figure_of.h"

namespace palpate::bench {
namespace {

using test::Random;
using test::Vec2;

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
