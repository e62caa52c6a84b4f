#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include <gtest/gtest.h>

#include "server/physics/cut/cut_rows.h"
#include "server/physics/energy/energy_solver.h"
#include "server/physics/limits.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/cut_of_rows.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using limits::energy::kRigid;
using test::Random;

/// The solver with cutting rows only.
struct CutSolver {
  EnergySolver energies{16, 400};
  QpResult Solve(const double* t, CutRows& rows, const double* start) {
    Energy* const cut = &rows;
    return energies.Solve(ActiveKernels(), t, {}, {&cut, 1}, start, {});
  }
};

Vec6 RowOf(const CutRows& rows, int i) {
  Vec6 a;
  for (int r = 0; r < 6; ++r) a[r] = -rows.yielding.rows.a[r][i];
  return a;
}

double GapOf(const CutRows& rows, int i) {
  return -rows.yielding.rows.b[i];
}

/// The exact law, without the solver's springs below the threshold.
double EnergyOf(const CutRows& rows, const Vec6& t, const Vec6& x) {
  double sum = 0.5 * (x - t).squaredNorm();
  for (int i = 0; i < rows.count(); ++i) {
    const double delta = std::max(0.0, RowOf(rows, i).dot(x) - GapOf(rows, i));
    sum += rows.yielding.threshold[i] * delta + 0.5 * rows.yielding.weight[i] * delta * delta;
  }
  return sum;
}

struct Problem {
  CutRows rows{400};
  double t[6] = {};
};

/// Rows of a pressed bur with or without gaps, from below the threshold to far above it; `turns`:
/// whether they turn it.
Problem RandomProblem(Random& random, int most_rows, bool turns = true) {
  Problem problem;
  const Vec3 towards = random.Direction();
  const int count = 1 + random.Below(most_rows);
  const double share = std::pow(10.0, random.Uniform(-3.0, 1.0));
  const double viscous = random.Below(4) == 0 ? 0.0 : std::pow(10.0, random.Uniform(-4.0, 1.0));
  const bool hollow = random.Below(2) == 0;
  const double size = std::pow(10.0, random.Uniform(-7.0, -3.3));
  for (int i = 0; i < count; ++i) {
    Vec3 n = random.Direction();
    if (random.Below(10) > 0 && n.dot(towards) < 0.0) n = -n;
    const Vec3 turn = random.InCube(turns ? 0.5 : 0.0);
    const double gap = hollow || random.Below(2) == 0 ? 0.0 : random.Uniform(0.0, size);
    problem.rows.Add({-n.x(), -n.y(), -n.z(), -turn.x(), -turn.y(), -turn.z()}, -gap,
                     size * random.Uniform(0.1, 1.0) / (share * count),
                     viscous * random.Uniform(0.1, 1.0) / count, 1e-9);
  }
  const Vec3 v = size * towards, phi = size * random.InCube(turns ? 0.5 : 0.0);
  for (int r = 0; r < 3; ++r) {
    problem.t[r] = v[r];
    problem.t[3 + r] = phi[r];
  }
  return problem;
}

/// The optimality conditions: each row's force is one that the law allows at its overlap, where
/// below the threshold an overlap of force / kRigid counts as none; and the forces balance.
void ExpectOptimal(const Problem& problem, const QpResult& step) {
  const CutRows& rows = problem.rows;
  const Vec6 x = Vec6::Map(step.x), t = Vec6::Map(problem.t);
  Vec6 sum = x - t;
  double size = x.norm() + t.norm();
  for (int i = 0; i < rows.count(); ++i) {
    const double s = RowOf(rows, i).dot(x) - GapOf(rows, i), force = rows.yielding.push[i];
    const double P = rows.yielding.threshold[i], above = rows.yielding.weight[i] * std::max(0.0, s);
    EXPECT_GE(force, 0.0);
    EXPECT_LE(force, P + above + 1e-12 * P);
    const double rounding = 1e-15 * (x.norm() + t.norm() + GapOf(rows, i));
    if (s < -rounding) {
      EXPECT_EQ(force, 0.0);
    } else if (force < P) {
      EXPECT_LE(s, P / kRigid + rounding);
    } else {
      EXPECT_NEAR(force, P + above, (1e-12 + rounding * kRigid) * (P + above));
    }
    sum += force * RowOf(rows, i);
    size += force;
  }
  // Rounding of x times each row's spring, and of solving by Cholesky's factor (Higham, Accuracy
  // and Stability of Numerical Algorithms, 2002, theorem 10.4).
  const double roundings = 1e-15 + (3 * 6 + 1) * 1.1e-16;
  EXPECT_LT(sum.norm(), 1e-13 * size + roundings * kRigid * rows.count() * x.norm());
  EXPECT_EQ(step.status, QpStatus::kSolved);
}

void SolveMany(bool turns, std::uint64_t seed, int problems, int most_rows, int& most_turns) {
  Random random(seed);
  CutSolver solver;
  const double zero[6] = {};
  for (int n = 0; n < problems; ++n) {
    Problem problem = RandomProblem(random, most_rows, turns);
    const QpResult step = solver.Solve(problem.t, problem.rows, zero);
    ExpectOptimal(problem, step);
    const std::span forces(problem.rows.yielding.push,
                           static_cast<std::size_t>(problem.rows.count()));
    const double rounding = 1e-15 * Vec6::Map(problem.t).norm();  // of x
    EXPECT_GE(test::CutOfRows(problem.rows, step.x).work,
              -rounding * std::accumulate(forces.begin(), forces.end(), 0.0));
    most_turns = std::max(most_turns, step.iterations);
    if (testing::Test::HasFailure()) {
      ADD_FAILURE() << "problem " << n << " of seed " << seed << ", " << problem.rows.count()
                    << " rows, " << step.iterations << " turns";
      return;
    }
  }
}

TEST(CutEnergy, MeetsTheOptimalityConditionsOfTheLaw) {
  int most_turns = 0;
  SolveMany(false, 1, 5000, 8, most_turns);
  SolveMany(true, 2, 5000, 8, most_turns);
  SolveMany(false, 3, 3000, 400, most_turns);
  SolveMany(true, 4, 3000, 400, most_turns);
  RecordProperty("most_turns", most_turns);
  EXPECT_LT(most_turns, 300);  // each row that comes to rest, or no longer does, counts
}

// The reference ascends the dual a force at a time (Hildreth 1957), clamped to what the law allows.
TEST(CutEnergy, FindsWhatSlowAscentOfTheDualFinds) {
  Random random(5);
  CutSolver solver;
  const double zero[6] = {};
  for (int n = 0; n < 300; ++n) {
    Problem problem = RandomProblem(random, 6);
    CutRows& rows = problem.rows;
    Vec6 x = Eigen::Map<const Vec6>(problem.t);
    std::vector<double> force(static_cast<std::size_t>(rows.count()), 0.0);
    for (int sweep = 0; sweep < 20000; ++sweep) {
      double change = 0.0;
      for (int i = 0; i < rows.count(); ++i) {
        const Vec6 a = RowOf(rows, i);
        double& f = force[static_cast<std::size_t>(i)];
        const double P = rows.yielding.threshold[i], c = rows.yielding.weight[i];
        // Without force f the row's overlap is s; f reduces it by f |a|^2, up to the law's force.
        const double square = a.squaredNorm(), s = a.dot(x) - GapOf(rows, i) + f * square;
        double wanted = std::clamp(s / square, 0.0, P);
        if (s - P * square > 0.0) wanted = (P + c * s) / (1.0 + c * square);
        x -= (wanted - f) * a;
        change = std::max(change, std::abs(wanted - f));
        f = wanted;
      }
      if (change < 1e-20) break;
    }
    const QpResult step = solver.Solve(problem.t, rows, zero);
    const Vec6 found = Eigen::Map<const Vec6>(step.x);
    // A row's spring yields by |t| / kRigid; two rows at a small angle yield more.
    const double t = Eigen::Map<const Vec6>(problem.t).norm();
    EXPECT_LT((found - x).norm(), 10.0 * t / kRigid + 1e-9 * x.norm()) << n;
  }
}

// Neither a point near the result nor one on the line to the target costs less.
TEST(CutEnergy, NoOtherStepCostsLess) {
  Random random(6);
  CutSolver solver;
  const double zero[6] = {};
  for (int n = 0; n < 200; ++n) {
    Problem problem = RandomProblem(random, 40, false);
    const Vec6 t = Vec6::Map(problem.t);
    const QpResult step = solver.Solve(problem.t, problem.rows, zero);
    const Vec6 x = Vec6::Map(step.x);
    const double least = EnergyOf(problem.rows, t, x);
    // The law's energy at the springs' overlaps f / kRigid; |t| bounds the forces f.
    double spring = 0.0;
    for (int i = 0; i < problem.rows.count(); ++i) {
      const double P = problem.rows.yielding.threshold[i];
      spring += P * std::min(P, t.norm()) / kRigid;
    }
    for (int k = 0; k < 300; ++k) {
      const double far = t.norm() * std::pow(10.0, random.Uniform(-6.0, 0.5));
      Vec6 other = x;
      if (k < 100) other = 0.01 * k * t;
      if (k >= 100) other.head<3>() += far * random.Direction();
      EXPECT_GE(EnergyOf(problem.rows, t, other), least - spring - 1e-14 * least);
    }
  }
}

TEST(CutEnergy, DoesNotDependOnTheGuess) {
  Random random(7);
  CutSolver solver;
  for (int n = 0; n < 500; ++n) {
    Problem problem = RandomProblem(random, 300);
    const double zero[6] = {};
    double wild[6];
    for (double& w : wild) w = random.Uniform(-1e-3, 1e-3);
    const QpResult one = solver.Solve(problem.t, problem.rows, zero);
    const QpResult other = solver.Solve(problem.t, problem.rows, wild);
    const Vec6 a = Eigen::Map<const Vec6>(one.x), b = Eigen::Map<const Vec6>(other.x);
    EXPECT_EQ(other.status, QpStatus::kSolved);
    EXPECT_LT((a - b).norm(), 1e-11 + 1e-9 * a.norm()) << n;
  }
}

TEST(CutEnergy, BelowTheThresholdNothingMovesAndAboveItIsViscous) {
  // One row along z: a threshold of 0.5 N at 1 N/mm, and c = 1: the bur moves by half of any
  // excess.
  CutRows rows(1);
  rows.Add({0, 0, -1, 0, 0, 0}, 0.0, 0.5e-3, 1.0, 1e-9);
  CutSolver solver;
  const double zero[6] = {};
  for (const double z : {0.1e-3, 0.4999e-3, 0.6e-3, 2e-3}) {
    const double t[6] = {0.2e-3, 0.0, z};
    const QpResult step = solver.Solve(t, rows, zero);
    EXPECT_NEAR(step.x[2], std::max(0.0, (z - 0.5e-3) / 2.0), 0.5e-3 / kRigid);
    EXPECT_NEAR(step.x[0], 0.2e-3, 1e-17);  // along the surface it is free
    EXPECT_NEAR(rows.yielding.push[0], z - step.x[2], 1e-15);
  }
}

TEST(CutEnergy, NoRowsNoForce) {
  CutRows rows(1);
  CutSolver solver;
  const double t[6] = {1e-3, -2e-3, 3e-3, 1e-4, 0, 1}, zero[6] = {};
  const QpResult step = solver.Solve(t, rows, zero);
  for (int r = 0; r < 6; ++r) EXPECT_EQ(step.x[r], t[r]);
  EXPECT_EQ(test::CutOfRows(rows, step.x).work, 0.0);
}

TEST(CutEnergy, SolvesWithoutAskingForMemory) {
  Random random(8);
  CutSolver solver;
  Problem problem = RandomProblem(random, 300);
  const double zero[6] = {};
  const std::uint64_t before = test::AllocationsOfThisThread();
  const QpResult step = solver.Solve(problem.t, problem.rows, zero);
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
  EXPECT_EQ(step.status, QpStatus::kSolved);
}

}  // namespace
}  // namespace palpate
