#pragma once

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "server/physics/haptic_step.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/random.h"
#include "tests/support/step_bench.h"
#include "tests/support/test_trees.h"

// Tools, ground and hands for the tests of both friction models.
namespace palpate::test {

inline StepParameters Rubbing(FrictionModel model) {
  StepParameters parameters;
  parameters.features.friction = model;
  return parameters;
}

inline Paint Rough(double mu_s, double mu_d) {
  Material material;
  material.static_friction = mu_s;
  material.dynamic_friction = mu_d;
  return AllOf(material);
}

/// A ball whose top is a plane at z = 0, flat to 2 um over 0.6 m.
inline const std::vector<Ball> kPlane{{Vec3(0.0, 0.0, -1e5), 1e5}};
inline const std::vector<Ball> kBallTool{{Vec3::Zero(), 0.005}};

/// Balls at a box's corners; the lower ones end 10 mm below the centroid, `half` to each side.
inline std::vector<Ball> BoxTool(double half = 0.02) {
  std::vector<Ball> corners;
  for (const double x : {-half, half}) {
    for (const double y : {-half, half}) {
      for (const double z : {-0.0095, 0.0095}) corners.push_back({Vec3(x, y, z), 0.0005});
    }
  }
  return corners;
}

inline Ball Plane(const Vec3& normal) {
  return {-1e5 * normal.normalized(), 1e5};
}

inline double Ratio(const StepReport& report, const Vec3& normal) {
  const double pressed = report.wrench.force.dot(normal);
  return (report.wrench.force - pressed * normal).norm() / pressed;
}

/// Runs each test with a ball and with a box.
class FrictionTool : public testing::TestWithParam<bool> {
 protected:
  std::vector<Ball> tool() const { return GetParam() ? BoxTool() : kBallTool; }
  double rest() const { return GetParam() ? 0.01 : 0.005; }  ///< height at which it touches
};

/// Steps with a hand that wanders within 5 mm and 0.2 rad of the graphic tool.
template <class Each>
void Wander(Bench& bench, Random& random, int steps, Each each) {
  Pose X = bench.state().X_WG, goal = X;
  for (int i = 0; i < steps; ++i) {
    if (i % 200 == 0) goal = {random.InCube(0.05), random.Rotation()};
    X.p += 0.01 * (goal.p - X.p);
    X.q = X.q.slerp(0.01, goal.q);
    const Vec3 off = X.p - bench.state().X_WG.p;
    if (off.norm() > 5e-3) X.p -= (1.0 - 5e-3 / off.norm()) * off;
    const Vec3 turn = RotationLog(X.q * bench.state().X_WG.q.conjugate());
    if (turn.norm() > 0.2) X.q = RotationExp(0.2 / turn.norm() * turn) * bench.state().X_WG.q;
    Pose hand = X;
    hand.p += random.InCube(20e-6);
    each(bench.Step(hand));
  }
}

/// Expects no allocation while a hand wanders among random objects.
inline void ExpectNoAllocation(FrictionModel model) {
  Random random(76);
  Bench bench(RandomBalls(random, 60, 0.02, 0.004), RandomBalls(random, 200, 0.05, 0.005),
              Rubbing(model), Rough(0.8, 0.3));
  bench.state().X_WG = At(0.0, 0.0, 0.15);
  const std::uint64_t before = AllocationsOfThisThread();
  int contacts = 0;
  Wander(bench, random, 2000, [&](const StepReport& report) { contacts += report.contacts; });
  EXPECT_EQ(AllocationsOfThisThread(), before);
  EXPECT_GT(contacts, 1000);
}

}  // namespace palpate::test
