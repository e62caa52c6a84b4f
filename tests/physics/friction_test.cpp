#include "server/physics/friction.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "tests/support/step_bench.h"

namespace palpate {
namespace {

using test::At;
using test::Ball;
using test::Bench;
using test::Random;
using test::RandomBalls;

constexpr double kStiffness = 1000.0;

StepParameters Rubbing(FrictionModel model) {
  StepParameters parameters;
  parameters.features.friction = model;
  return parameters;
}

Material Rough(double mu_s, double mu_d) {
  Material material;
  material.static_friction = mu_s;
  material.dynamic_friction = mu_d;
  return material;
}

/// A ball whose top is a plane at z = 0, flat to 0.1 nm over the slides here.
const std::vector<Ball> kPlane{{Vec3(0.0, 0.0, -1e6), 1e6}};
const std::vector<Ball> kBallTool{{Vec3::Zero(), 0.005}};

/// Four feet at the corners of a square of 40 mm, their soles 10 mm below the centroid.
std::vector<Ball> BoxTool() {
  std::vector<Ball> feet;
  for (const double x : {-0.02, 0.02}) {
    for (const double y : {-0.02, 0.02}) feet.push_back({Vec3(x, y, -0.008), 0.002});
  }
  return feet;
}

TEST(Friction, Rnd) {
  // Random tools pushed about in random objects.
  for (double mu : {0.2, 0.5, 1.0}) for (double amp: {0.0, 1.0}) {
  int its = 0, steps = 0, uns = 0, maxits = 0, contactsteps = 0, multi=0; double cone = 0, sum = 0, tsum=0;
  int hist[10] = {};
  for (int scene = 0; scene < 30; ++scene) {
    Random random(1000 + scene);
    Bench bench(RandomBalls(random, 60, 0.02, 0.004), RandomBalls(random, 200, 0.05, 0.005), Rubbing(FrictionModel::kCoulomb), Rough(1.5 * mu, mu));
    bench.state().X_WG = At(0, 0, 0.15);
    Pose X = At(0, 0, 0.15), goal = X;
    for (int i = 0; i < 2000; ++i) {
      if (i % 200 == 0) { goal.p = random.InCube(0.05); goal.q = random.Rotation(); }
      X.p += 0.01 * (goal.p - X.p);
      X.q = X.q.slerp(0.01, goal.q);
      Pose Y = X; Y.p += amp * random.InCube(20e-6);
      const StepReport r = bench.Step(Y);
      ++steps;
      if (r.contacts == 0) continue;
      ++contactsteps; multi += r.contacts > 1;
      its += r.friction_iterations; maxits = std::max(maxits, r.friction_iterations); uns += r.friction_unsolved;
      hist[std::min(9, r.friction_iterations / 5)]++;
      Vec3 f = Vec3::Zero();
      Vec3 tq = Vec3::Zero();
      for (int k = 0; k < r.contacts; ++k) {
        const auto& c = r.active[k];
        f += c.force * c.normal + c.friction;
        tq += c.force * c.lever_cross_normal + (c.contact_W - r.X_WG * bench.model().reference()).cross(c.friction);
        cone = std::max(cone, c.friction.norm() - 1.5 * mu * c.force);
      }
      sum = std::max(sum, (f - r.wrench.force).norm());
      tsum = std::max(tsum, (tq - r.wrench.torque).norm());
    }
  }
  printf("mu %g noise %g: %d steps %d in contact %d multi, its %.3f max %d uns %d cone %g sum %g torque %g  hist", mu, amp, steps, contactsteps, multi, double(its) / contactsteps, maxits, uns, cone, sum,tsum);
  for (int h : hist) printf(" %d", h);
  printf("\n");
  }
}

TEST(Friction, Scratch) {
  for (int box = 0; box < 2; ++box) {
    for (double speed : {1e-3, 1e-2, 0.1, 0.3}) {
      Bench bench(box ? BoxTool() : kBallTool, kPlane, Rubbing(FrictionModel::kCoulomb),
                  Rough(0.6, 0.4));
      const double rest = box ? 0.01 : 0.005;
      bench.state().X_WG = At(0, 0, rest);
      double worst = 0;
      int its = 0, uns = 0, qp=0, maxits = 0;
      for (int i = 0; i < 3000; ++i) {
        const StepReport r = bench.Step(At(speed * 1e-3 * i, 0, rest - 1e-3));
        const double ratio = std::hypot(r.wrench.force.x(), r.wrench.force.y()) / r.wrench.force.z();
        its += r.friction_iterations; maxits = std::max(maxits, r.friction_iterations);
        uns += r.friction_unsolved;qp+=r.qp_iterations;
        if (i % 500 == 499 || i < 5) printf("box %d speed %g i %d ratio %.9f its %d contacts %d\n", box, speed, i, ratio, r.friction_iterations, r.contacts);
        if (i > 2000) worst = std::max(worst, std::fabs(ratio / 0.4 - 1));
      }
      printf("worst %g its %g max %d uns %d\n", worst, its / 3000., maxits, uns);
    }
  }
}

}  // namespace
}  // namespace palpate
