// Two smooth bodies that lie along each other: very many leaves come within a hand's reach.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "server/physics/rows/contact_prediction.h"
#include "server/physics/solve/response.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/step_bench.h"

namespace palpate {
namespace {

using test::Ball;
using test::Bench;
using test::Random;

constexpr double kGolden = 2.399963229728653;  // angle between neighbours of a sunflower [rad]

/// Balls of one radius that touch an ellipsoid from inside.
std::vector<Ball> Ellipsoid(const Vec3& semi_axes, double radius, int count) {
  std::vector<Ball> balls;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, r = std::sqrt(1.0 - z * z);
    const Vec3 u(r * std::cos(kGolden * i), r * std::sin(kGolden * i), z);
    const Vec3 normal = u.cwiseQuotient(semi_axes).normalized();
    balls.push_back({u.cwiseProduct(semi_axes) - radius * normal, radius});
  }
  return balls;
}

const Vec3 kEgg(0.03, 0.02, 0.02), kTool(0.01, 0.008, 0.008);

struct TwoEllipsoids {
  static constexpr int kLeaves = 3076;
  explicit TwoEllipsoids(const StepParameters& parameters = {}, const Material& material = {})
      : bench(tool, egg, parameters, test::AllOf(material)) {}
  std::vector<Ball> tool = Ellipsoid(kTool, 6e-3, kLeaves), egg = Ellipsoid(kEgg, 12e-3, kLeaves);
  Bench bench;
};

/// A hand that comes in at 10 cm/s, and then rolls and slides along the egg, 1 to 2 mm below where
/// its tool touches.
class Hand {
 public:
  explicit Hand(std::uint64_t seed) {
    Random random(seed);
    turned_ = random.Rotation();
    axis_ = random.InCube(1.0).normalized();
    from_ = axis_.unitOrthogonal();
  }
  static constexpr double kIn = 0.1, kEnd = 0.25;  // [s]

  Pose At(double t) const {
    const double turn = 3.0 * std::max(t - kIn, 0.0), out = 0.1 * std::max(kIn - t, 0.0);
    const Vec3 u = RotationExp(turn * axis_) * from_;
    return {u.cwiseProduct(kEgg + Vec3::Constant(7e-3 + out)),
            (RotationExp(turn * axis_) * turned_).normalized()};
  }

 private:
  Quat turned_;
  Vec3 axis_, from_;
};

Pose Centre(const Bench& bench, const Pose& X) {
  return {X * bench.model().reference(), X.q};
}

/// The force at the optimum under the rows of all pairs within `reach` of the tool's pose.
Vec3 ForceUnderAllRows(const TwoEllipsoids& two, const Pose& X_WG, const Pose& X_WH, double reach) {
  const HapticModel& model = two.bench.model();
  const Pose G = Centre(two.bench, X_WG), H = Centre(two.bench, X_WH);
  const double rho = model.rotation_length();
  std::vector<double> a[6], b;
  for (const Ball& t : two.tool) {
    const Vec3 c = X_WG * t.center, lever = c - G.p;
    for (const Ball& o : two.egg) {
      const Vec3 apart = c - o.center;
      const double least = t.radius + o.radius;
      if (apart.squaredNorm() > (least + reach) * (least + reach)) continue;
      const Vec3 n = apart.normalized(), turned = lever.cross(n) / rho;
      for (int k = 0; k < 3; ++k) {
        a[k].push_back(n[k]);
        a[3 + k].push_back(turned[k]);
      }
      b.push_back(least - apart.norm());
    }
  }
  QpRows rows{};
  rows.count = static_cast<int>(b.size());
  for (std::vector<double>& column : a) column.resize(b.size() + 16, 0.0);
  b.resize(b.size() + 16, -1e300);
  for (int k = 0; k < 6; ++k) rows.a[k] = a[k].data();
  rows.b = b.data();
  const Target target = TargetOf(G.p, G.q, H.p, H.q);
  Vec6 t;
  t << target.v, rho * target.phi;
  const QpResult best = SolveNearestPoint(t.data(), rows, nullptr, 0);
  return model.parameters().stiffness * (Vec3::Map(best.x) - target.v);
}

TEST(PredictLeaves, FeelsAllPairsWithinReachAndEntersNone) {
  TwoEllipsoids two;
  int touching = 0;
  for (const std::uint64_t seed : {3u, 11u, 29u}) {
    const Hand hand(seed);
    two.bench.state() = StepState(two.bench.model());
    two.bench.state().X_WG = two.bench.state().X_WH = hand.At(0.0);
    for (int i = 0; i < 250; ++i) {
      const Pose X_WH = hand.At(1e-3 * i), before = two.bench.state().X_WG;
      const StepReport report = two.bench.Step(X_WH);
      ASSERT_EQ(report.faults, 0u) << seed << ' ' << i;
      ASSERT_LT(report.diagnostics.predicted_pairs, 8192);
      touching += report.contacts > 0 ? 1 : 0;
      if (i % 12 != 0 || report.diagnostics.substeps > 1) continue;
      ASSERT_LT(two.bench.Penetration(), 1e-6);
      const Vec3 force = ForceUnderAllRows(two, before, X_WH, 0.4e-3);
      ASSERT_LT((report.wrench.force - force).norm(), 1e-6) << seed << ' ' << i;
    }
  }
  EXPECT_GT(touching, 400);
}

TEST(PredictLeaves, FeelsWhatATenTimesSlowerHandFeels) {
  TwoEllipsoids two;
  const Hand hand(5);
  std::vector<Vec3> forces[2];
  for (const int parts : {1, 10}) {
    two.bench.state() = StepState(two.bench.model());
    two.bench.state().X_WG = two.bench.state().X_WH = hand.At(0.0);
    for (int i = 1; i <= 250 * parts; ++i) {
      const StepReport report = two.bench.Step(hand.At(1e-3 * i / parts));
      if (i % parts == 0) forces[parts == 1 ? 0 : 1].push_back(report.wrench.force);
    }
  }
  // The tool trails by about a step of the hand, 0.1 mm, times what turns in it: 3 mrad, 0.3 um.
  // More comes from where a leaf meets the next.
  for (std::size_t i = 0; i < forces[0].size(); ++i) {
    ASSERT_LT((forces[0][i] - forces[1][i]).norm(), 0.03) << i;
  }
}

TEST(PredictLeaves, DependsOnNothingButTheStateAndAllocatesNothing) {
  TwoEllipsoids two;
  const Hand hand(7);
  two.bench.state().X_WG = two.bench.state().X_WH = hand.At(0.0);
  bool crowded = false;
  for (int i = 0; i < 250; ++i) {
    StepState state = two.bench.state();
    StepWorkspace fresh(two.bench.model());
    const StepReport expected = HapticStep(two.bench.model(), hand.At(1e-3 * i), state, fresh);
    const std::uint64_t before = test::AllocationsOfThisThread();
    const StepReport report = two.bench.Step(hand.At(1e-3 * i));
    ASSERT_EQ(test::AllocationsOfThisThread(), before);
    ASSERT_EQ(report.wrench.force, expected.wrench.force);
    ASSERT_EQ(report.wrench.torque, expected.wrench.torque);
    ASSERT_EQ(report.X_WG.p, expected.X_WG.p);
    crowded = crowded || two.bench.state().is_crowded;
  }
  EXPECT_TRUE(crowded);
}

// A look more is one more problem with friction; it begins where the last one ended.
TEST(PredictLeaves, TakesFewStepsForFrictionOfEachLook) {
  StepParameters parameters;
  parameters.features.friction = FrictionModel::kCoulomb;
  TwoEllipsoids two(parameters, {.static_friction = 0.6, .dynamic_friction = 0.4});
  int crowded = 0, newton = 0;
  for (const std::uint64_t seed : {3u, 11u, 29u}) {
    const Hand hand(seed);
    two.bench.state() = StepState(two.bench.model());
    two.bench.state().X_WG = two.bench.state().X_WH = hand.At(0.0);
    for (int i = 0; i < 250; ++i) {
      const StepReport report = two.bench.Step(hand.At(1e-3 * i));
      ASSERT_EQ(report.faults, 0u) << seed << ' ' << i;
      ASSERT_EQ(report.diagnostics.friction_unsolved, 0) << seed << ' ' << i;
      for (int k = 0; k < report.contacts; ++k) {
        const ActiveRow& row = report.active[static_cast<std::size_t>(k)];
        ASSERT_LE(row.friction.norm(), 0.6 * row.force + 1e-6);
      }
      if (!two.bench.state().is_crowded || report.contacts == 0) continue;
      ++crowded;
      newton += report.diagnostics.friction_iterations;
    }
  }
  EXPECT_GT(crowded, 100);
  // At least two for each look, of which one lets the contacts hold their forces.
  EXPECT_LT(newton, 8 * crowded);
}

// Small balls and long ways, so that ways can pass through balls and end beyond them.
TEST(ContactPrediction, CoversAllStraightWaysToWhereASubStepMayEnd) {
  Random random(71);
  int met = 0, aside = 0;
  for (int candidate = 0; candidate < 60; ++candidate) {
    const std::vector<Ball> tool = test::RandomBalls(random, 60, 0.01, 0.4e-3);
    const std::vector<Ball> object = test::RandomBalls(random, 400, 0.02, 0.6e-3);
    Bench bench(tool, object);
    bench.state().X_WG = {random.InCube(0.01), random.Rotation()};
    const Pose X = bench.state().X_WG, G = Centre(bench, X);
    const double scale = random.Uniform(0.1e-3, 1.5e-3);
    const StepEnds ends{
        {0.2 * scale, 5.0 * scale}, random.InCube(scale), random.InCube(20.0 * scale)};
    ContactRows rows(30000, 0.03);
    ContactPrediction prediction(bench.model());
    ASSERT_TRUE(prediction.Predict(bench.model(), ActiveKernels(), G.q.toRotationMatrix(), G.p,
                                   ends, rows, nullptr));
    std::vector<bool> has(tool.size() * object.size());
    for (int r = 0; r < rows.count(); ++r) {
      has[static_cast<std::size_t>(rows.id(r).a) * object.size() +
          static_cast<std::size_t>(rows.id(r).b)] = true;
    }
    for (int k = 0; k < 20; ++k) {
      const Vec3 v = ends.v + random.InCube(1.0).normalized() * ends.bounds.translation;
      const Vec3 phi = ends.phi + random.InCube(1.0).normalized() * ends.bounds.rotation;
      const Quat q = RotationExp(phi) * G.q;
      for (std::size_t t = 0; t < tool.size(); ++t) {
        const LeafSphere& leaf = bench.model().tool().leaves[t];
        const Vec3 l(leaf.x, leaf.y, leaf.z), from = G.p + G.q * l, way = G.p + v + q * l - from;
        for (std::size_t o = 0; o < object.size(); ++o) {
          const LeafSphere& other = bench.model().objects().leaves[o];
          const Vec3 apart = from - Vec3(other.x, other.y, other.z);
          const double r = leaf.radius + other.radius;
          if (apart.norm() < r) continue;  // not apart at the beginning
          const double s = std::clamp(-apart.dot(way) / way.squaredNorm(), 0.0, 1.0);
          if ((apart + s * way).norm() >= r) continue;
          ++met;
          aside += (apart + way).norm() >= r ? 1 : 0;
          ASSERT_TRUE(has[t * object.size() + o]);
        }
      }
    }
  }
  EXPECT_GT(met, 1000);
  EXPECT_GT(aside, 100);  // those that end beyond a ball
}

}  // namespace
}  // namespace palpate
