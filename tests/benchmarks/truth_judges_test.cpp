#include "tests/benchmarks/truth_judges.h"

#include <string_view>

#include <gtest/gtest.h>

#include "tests/benchmarks/figure_of.h"

namespace palpate::bench {
namespace {

const Vec3 kRight = Vec3(-1.0, 1.0, 0.0).normalized(), kLeft = Vec3(1.0, 1.0, 0.0).normalized();

StepReport ReportOf(const Vec3& force) {
  StepReport report;
  report.wrench.force = force;
  report.contacts = 2;
  return report;
}

/// Judges a steady slide along z in a groove of right angles.
SteadyJudge Slid(const Vec3& force) {
  SteadyJudge judge({.normals = {kRight, kLeft},
                     .along = Vec3::UnitZ(),
                     .speed = 0.01,
                     .reach = 0.01,
                     .stiffness = 1000.0,
                     .steady = 1,
                     .depth = std::vector<double>(10, 1e-3)},
                    Quat::Identity());
  for (std::size_t i = 0; i < 10; ++i) judge.See(i, ReportOf(force));
  return judge;
}

TEST(TruthJudges, AskInAGrooveForFrictionOfTheSumOfBothLoads) {
  const Vec3 loads = 2.0 * kRight + 3.0 * kLeft;
  const SteadyJudge right = Slid(loads - kTruthDynamic * 5.0 * Vec3::UnitZ());
  EXPECT_NEAR(FigureOf(right, "mu least"), kTruthDynamic, 1e-12);
  EXPECT_NEAR(FigureOf(right, "mu most"), kTruthDynamic, 1e-12);
  EXPECT_EQ(FigureOf(right, "1 % off"), 0.0);
  // Of what the hand presses with, as on a plane, is too little.
  const SteadyJudge wrong = Slid(loads - kTruthDynamic * loads.norm() * Vec3::UnitZ());
  EXPECT_EQ(FigureOf(wrong, "1 % off"), 1.0);
}

TEST(TruthJudges, SeeAForceAlongAGrooveAndATorqueThatNothingGives) {
  SmoothJudge judge({.axis = {Vec3::UnitZ()}, .across = true, .force = {kRight, kRight}});
  StepReport report = ReportOf(kRight);
  judge.See(0, report);
  EXPECT_EQ(FigureOf(judge, "over 0.01 N"), 0.0);
  EXPECT_EQ(FigureOf(judge, "force off N"), 0.0);
  report.wrench = {kRight + 0.02 * Vec3::UnitZ(), 0.003 * Vec3::UnitX()};
  judge.See(1, report);
  EXPECT_NEAR(FigureOf(judge, "sideways N"), 0.02, 1e-15);
  EXPECT_NEAR(FigureOf(judge, "force off N"), 0.02, 1e-15);
  EXPECT_NEAR(FigureOf(judge, "torque N m"), 0.003, 1e-15);
  EXPECT_EQ(FigureOf(judge, "over 0.01 N"), 1.0);
}

}  // namespace
}  // namespace palpate::bench
