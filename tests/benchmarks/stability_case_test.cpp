#include "tests/benchmarks/stability_case.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "tests/support/random.h"

namespace palpate::bench {
namespace {

// One test per name, so that a failure names its case.
std::string NameOf(const std::string& contact, const StabilityCase& stability_case) {
  std::string name = contact + "_" + stability_case.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

struct Named {
  std::string name;
  Features features;
  StabilityCase stability_case;
};

void PrintTo(const Named& named, std::ostream* out) {
  *out << named.name;
}

std::vector<Named> AllCases() {
  std::vector<Named> all;
  for (const ContactModel contact : {ContactModel::kSpheres, ContactModel::kSurface}) {
    Features features;
    features.contact = contact;
    for (const StabilityCase& c : StabilityCases()) {
      if (!c.applies(features)) continue;
      all.push_back(
          {NameOf(contact == ContactModel::kSpheres ? "Spheres" : "Surface", c), features, c});
    }
  }
  return all;
}

class HardCase : public testing::TestWithParam<Named> {};

TEST_P(HardCase, Holds) {
  const StabilityCase& hard = GetParam().stability_case;
  CaseRun run;
  run.steps = hard.least;
  run.features = GetParam().features;
  hard.run(run);
  EXPECT_GE(run.done, hard.least / 2);
  EXPECT_TRUE(Held(hard, run)) << hard.what << ": " << run.figure << " " << hard.unit << ", bound "
                               << hard.bound << "; tunnelled " << run.tunnelled << ", not finite "
                               << run.nonfinite << ", overlap " << 1e6 * run.penetration << " um";
}

INSTANTIATE_TEST_SUITE_P(All, HardCase, testing::ValuesIn(AllCases()),
                         [](const auto& test_case) { return test_case.param.name; });

TEST(StabilityCase, IsNotHeldByAnythingThatGoesWrong) {
  StabilityCase hard;
  hard.bound = 1.0;
  CaseRun good;
  good.done = 1;
  good.figure = 1.0;
  good.penetration = kAllowedOverlap;
  EXPECT_TRUE(Held(hard, good));
  CaseRun bad = good;
  bad.figure = 1.001;
  EXPECT_FALSE(Held(hard, bad));
  bad = good;
  bad.figure = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Held(hard, bad));
  bad = good;
  bad.tunnelled = 1;
  EXPECT_FALSE(Held(hard, bad));
  bad = good;
  bad.nonfinite = 1;
  EXPECT_FALSE(Held(hard, bad));
  bad = good;
  bad.penetration = 1.01 * kAllowedOverlap;
  EXPECT_FALSE(Held(hard, bad));
  bad = good;
  bad.done = 0;
  EXPECT_FALSE(Held(hard, bad));
}

TEST(StabilityCase, IsAllOfTheListAndNamesEachOnce) {
  std::vector<std::string> names;
  for (const StabilityCase& c : StabilityCases()) names.push_back(c.name);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
  EXPECT_GE(names.size(), 30u);
}

TEST(OverlapOf, KnowsBoxesAndBallsInClosedForm) {
  const Solid box = Box({0.02, 0.04, 0.06}, 1), ball = Ball(0.01);
  const auto at = [](double x, double y, double z) {
    return Pose{Vec3(x, y, z), Quat::Identity()};
  };
  EXPECT_NEAR(OverlapOf(box, {}, ball, at(0.019, 0, 0)), 0.001, 1e-15);
  EXPECT_EQ(OverlapOf(box, {}, ball, at(0.021, 0, 0)), 0.0);
  // At an edge the box's offset is round: the centre is 6 and 7.5 mm beyond it.
  EXPECT_NEAR(OverlapOf(ball, at(0.016, 0.0275, 0), box, {}), 0.01 - std::hypot(0.006, 0.0075),
              1e-15);
  EXPECT_NEAR(OverlapOf(ball, {}, ball, at(0, 0, 0.0195)), 0.0005, 1e-15);
  // A box on its edge over a box: half diagonals.
  const Pose on_edge{Vec3(0, 0, 0.03 + 0.01 * std::sqrt(2.0) - 1e-4),
                     RotationExp(Vec3(0, M_PI / 4, 0))};
  EXPECT_NEAR(OverlapOf(Box(Vec3::Constant(0.02), 1), on_edge, box, {}), 1e-4, 1e-12);
  EXPECT_EQ(OverlapOf(box, {}, box, at(0.0201, 0, 0)), 0.0);
}

TEST(OverlapOf, AgreesWithPointsOfOneBoxInTheOther) {
  // A point of A deeper in B than the overlap would contradict it; disjoint boxes do not overlap.
  test::Random random(5);
  const Solid A = Box({0.02, 0.03, 0.04}, 1), B = Box({0.05, 0.01, 0.03}, 1);
  int meeting = 0;
  for (int i = 0; i < 2000; ++i) {
    const Pose X_WA{random.InCube(0.03), random.Rotation()}, X_WB{Vec3::Zero(), random.Rotation()};
    const double overlap = OverlapOf(A, X_WA, B, X_WB);
    double deepest = 0.0;
    for (int n = 0; n < 500; ++n) {
      const Vec3 p = X_WA * Vec3(random.InCube(1.0).cwiseProduct(A.half));
      const Vec3 inside = B.half - Vec3(X_WB.Inverse() * p).cwiseAbs();
      deepest = std::max(deepest, inside.minCoeff());
    }
    meeting += deepest > 0.0;
    EXPECT_TRUE(overlap > 0.0 || deepest == 0.0);
    EXPECT_DOUBLE_EQ(overlap, OverlapOf(B, X_WB, A, X_WA));
  }
  EXPECT_GT(meeting, 200);
}

}  // namespace
}  // namespace palpate::bench
