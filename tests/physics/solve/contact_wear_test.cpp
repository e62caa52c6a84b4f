#include "server/physics/solve/contact_wear.h"

#include <gtest/gtest.h>

#include "tests/support/step_bench.h"

namespace palpate {
namespace {

using test::AllOf;
using test::At;
using test::Bench;

StepParameters Removing() {
  StepParameters parameters;
  parameters.features.removal = true;
  return parameters;
}

TEST(ContactWear, IsTheNormalForceTimesTheSlipWithoutFriction) {
  // A ball pressed 1 mm into a plane, so with 1 N, and drawn along it: a joule a metre.
  Bench bench({{Vec3::Zero(), 0.005}}, {{Vec3(0.0, 0.0, -1e4), 1e4}}, Removing(),
              AllOf({.hardness = 0.02}));
  bench.state().X_WG = At(0.0, 0.0, 0.0051);
  bench.Repeat(At(0.0, 0.0, 0.004), 20);
  const double before = bench.state().wear.hardness_left(0);
  EXPECT_NEAR(before, 0.02, 1e-9);
  for (int i = 1; i <= 100; ++i) bench.Step(At(1e-4 * i, 0.0, 0.004));
  EXPECT_NEAR(bench.state().wear.hardness_left(0), before - 0.01, 1e-6);
  // Pressing harder or standing still costs nothing.
  const double worn = bench.state().wear.hardness_left(0);
  for (int i = 0; i < 100; ++i) bench.Step(At(0.01, 0.0, 0.004 - 1e-5 * i));
  EXPECT_NEAR(bench.state().wear.hardness_left(0), worn, 1e-8);
}

TEST(ContactWear, IsTheDynamicFrictionsWorkWithIt) {
  StepParameters parameters = Removing();
  parameters.features.friction = FrictionModel::kCoulomb;
  Bench bench({{Vec3::Zero(), 0.005}}, {{Vec3(0.0, 0.0, -1e4), 1e4}}, parameters,
              {{Material{.hardness = 1.0}}, [](const Vec3&) { return 0; }});
  bench.state().X_WG = At(0.0, 0.0, 0.0051);
  for (int i = 1; i <= 100; ++i) bench.Step(At(1e-4 * i, 0.0, 0.004));
  EXPECT_EQ(bench.state().wear.hardness_left(0), 1.0);  // mu_d = 0: nothing rubs
}

TEST(ContactWear, SaysWhichLeafGoesAndInWhatStep) {
  Bench bench({{Vec3::Zero(), 0.005}}, {{Vec3(0.0, 0.0, -1e4), 1e4}}, Removing(),
              AllOf({.hardness = 0.02}));
  StepReport report;
  ActiveRow& row = report.active[0];
  row.object_leaf = 0;
  row.material = &bench.model().objects().MaterialOf(0);
  row.normal = Vec3::UnitZ();
  row.force = 2.0;
  report.contacts = 1;
  // The tool slides by 6 mm and lifts by 1 mm, which is no slip: 12 mJ at a time.
  for (const int removals : {0, 1}) {
    report.X_WG = At(0.006, 0.0, 0.001);
    row.contact_W = report.X_WG.p;
    WearContacts(bench.model(), At(0.0, 0.0, 0.0), bench.state().wear, report);
    EXPECT_EQ(report.removals, removals);
  }
  EXPECT_EQ(report.removed[0], 0);
  EXPECT_TRUE(bench.state().wear.gone(0));
}

}  // namespace
}  // namespace palpate
