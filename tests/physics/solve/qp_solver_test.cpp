#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "server/physics/energy/energy_solver.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;

/// min 1/2 |x - t|^2 subject to A x >= b, with its storage by columns.
struct RigidProblem {
  Vec t;
  Mat A;
  Vec b;
  std::vector<double> columns;

  /// Problems in fewer than six unknowns leave the others zero.
  Vec6 Target() const {
    Vec6 target = Vec6::Zero();
    target.head(t.size()) = t;
    return target;
  }
  QpRows Rows() {
    const int m = static_cast<int>(b.size());
    const int padded = std::max(16, (m + 15) & ~15);
    columns.assign(static_cast<std::size_t>(7 * padded + 8), 0.0);
    auto address = reinterpret_cast<std::uintptr_t>(columns.data());
    double* base = columns.data() + (64 - address % 64) % 64 / sizeof(double);
    QpRows rows{};
    for (int c = 0; c < 6; ++c) {
      for (int i = 0; i < m && c < A.cols(); ++i) base[c * padded + i] = A(i, c);
      rows.a[c] = base + c * padded;
    }
    double* b_column = base + 6 * padded;
    for (int i = 0; i < padded; ++i) b_column[i] = i < m ? b[i] : -1e300;
    rows.b = b_column;
    rows.count = m;
    return rows;
  }
};

QpResult SolveProblem(RigidProblem& problem) {
  const QpRows rows = problem.Rows();
  return ActiveKernels().solve(problem.Target().data(), rows, nullptr, 0);
}

/// Largest violation of the Karush-Kuhn-Tucker conditions, which are sufficient for the optimum.
/// Rows may be relaxed by a common `slack` with compliance c.
double KktResidual(const RigidProblem& problem, const QpResult& result) {
  Vec x = Eigen::Map<const Vec>(result.x, problem.t.size());
  Vec gradient = x - problem.t;
  double worst = 0.0, sum = 0.0;
  for (int j = 0; j < result.active; ++j) {
    const auto a = problem.A.row(result.row[j]).transpose();
    gradient -= result.multiplier[j] * a;
    sum += result.multiplier[j];
    worst = std::max(worst, -result.multiplier[j]);
    worst = std::max(worst, std::abs(a.dot(x) + result.slack - problem.b[result.row[j]]));
  }
  worst = std::max(worst, gradient.cwiseAbs().maxCoeff());
  if (result.status == QpStatus::kRelaxed) {
    worst = std::max(worst, std::abs(result.slack - kJamCompliance * sum));
  }
  for (int i = 0; i < problem.b.size(); ++i) {
    worst = std::max(worst, problem.b[i] - result.slack - problem.A.row(i).dot(x));
  }
  return worst;
}

/// Exact and slow: tries every set of at most n rows as equalities.  Infinite if none is optimal.
double LeastDistanceByEnumeration(const RigidProblem& problem, Vec* best_x = nullptr) {
  const int n = static_cast<int>(problem.t.size());
  const int m = static_cast<int>(problem.b.size());
  double best = std::numeric_limits<double>::infinity();
  for (unsigned set = 0; set < (1u << m); ++set) {
    const int k = __builtin_popcount(set);
    if (k > n) continue;
    Mat A(k, n);
    Vec b(k);
    for (int i = 0, r = 0; i < m; ++i) {
      if ((set >> i & 1u) == 0) continue;
      A.row(r) = problem.A.row(i);
      b[r++] = problem.b[i];
    }
    Vec x = problem.t;
    if (k > 0) {
      const Eigen::ColPivHouseholderQR<Mat> qr(A * A.transpose());
      if (qr.rank() < k) continue;
      const Vec u = qr.solve(b - A * problem.t);
      if (u.minCoeff() < -1e-10) continue;
      x += A.transpose() * u;
    }
    if (m > 0 && (problem.A * x - problem.b).minCoeff() < -1e-9) continue;
    const double distance = (x - problem.t).norm();
    if (distance < best) {
      best = distance;
      if (best_x != nullptr) *best_x = x;
    }
  }
  return best;
}

RigidProblem RandomProblem(Random& random, int n, int m, bool feasible) {
  RigidProblem problem{Vec(n), Mat(m, n), Vec(m), {}};
  Vec inside(n);
  for (int c = 0; c < n; ++c) {
    problem.t[c] = random.Uniform(-1.0, 1.0);
    inside[c] = random.Uniform(-1.0, 1.0);
  }
  for (int i = 0; i < m; ++i) {
    for (int c = 0; c < n; ++c) problem.A(i, c) = random.Uniform(-1.0, 1.0);
    problem.A.row(i).normalize();
    problem.b[i] = feasible ? problem.A.row(i).dot(inside) - random.Uniform(0.0, 0.3)
                            : random.Uniform(-0.2, 1.0);
  }
  return problem;
}

TEST(QpSolver, AgreesWithEnumerationOfActiveSets) {
  Random random(1);
  for (int candidate = 0; candidate < 300; ++candidate) {
    const int n = candidate % 2 == 0 ? 6 : 3;
    RigidProblem problem = RandomProblem(random, n, 1 + random.Below(11), true);
    const QpResult result = SolveProblem(problem);
    Vec oracle;
    const double distance = LeastDistanceByEnumeration(problem, &oracle);
    ASSERT_TRUE(std::isfinite(distance)) << candidate;
    ASSERT_EQ(result.status, QpStatus::kSolved) << candidate;
    EXPECT_LT((Eigen::Map<const Vec>(result.x, n) - oracle).norm(), 1e-9) << candidate;
    EXPECT_LT(KktResidual(problem, result), 1e-12) << candidate;
  }
}

TEST(QpSolver, RelaxesContradictoryRowsByTheSlackThatEnumerationFinds) {
  Random random(2);
  int contradictory = 0;
  for (int candidate = 0; candidate < 200; ++candidate) {
    const int n = candidate % 2 == 0 ? 6 : 3;
    RigidProblem problem = RandomProblem(random, n, n + 4, false);
    const QpResult result = SolveProblem(problem);
    if (std::isfinite(LeastDistanceByEnumeration(problem))) {
      EXPECT_EQ(result.status, QpStatus::kSolved) << candidate;
      continue;
    }
    ++contradictory;
    ASSERT_EQ(result.status, QpStatus::kRelaxed) << candidate;
    EXPECT_LT(KktResidual(problem, result), 1e-8) << candidate;
    // The same problem with eta / sqrt(c) as an additional unknown.
    RigidProblem relaxed{Vec::Zero(n + 1), Mat(problem.A.rows(), n + 1), problem.b, {}};
    relaxed.t.head(n) = problem.t;
    relaxed.A << problem.A, Vec::Constant(problem.A.rows(), std::sqrt(kJamCompliance));
    Vec oracle;
    ASSERT_TRUE(std::isfinite(LeastDistanceByEnumeration(relaxed, &oracle)));
    EXPECT_NEAR(result.slack, std::sqrt(kJamCompliance) * oracle[n], 1e-7) << candidate;
    EXPECT_LT((Eigen::Map<const Vec>(result.x, n) - oracle.head(n)).norm(), 1e-5) << candidate;
  }
  EXPECT_GT(contradictory, 20);
}

TEST(QpSolver, ReturnsTheNearestPointWhenRowsRepeat) {
  RigidProblem problem{Vec::Zero(6), Mat::Zero(1000, 6), Vec::Constant(1000, 0.25), {}};
  problem.A.col(2).setOnes();
  const QpResult result = SolveProblem(problem);
  EXPECT_EQ(result.status, QpStatus::kSolved);
  EXPECT_EQ(result.active, 1);
  EXPECT_DOUBLE_EQ(result.x[2], 0.25);
  EXPECT_DOUBLE_EQ(result.multiplier[0], 0.25);
}

TEST(QpSolver, SharesTheViolationOfAJamEvenly) {
  // Two walls 1 mm closer than the tool is wide: it stays in the middle.
  RigidProblem problem{Vec::Zero(6), Mat::Zero(2, 6), Vec::Constant(2, 0.5e-3), {}};
  problem.A(0, 0) = 1.0;
  problem.A(1, 0) = -1.0;
  const QpResult result = SolveProblem(problem);
  EXPECT_EQ(result.status, QpStatus::kRelaxed);
  EXPECT_NEAR(result.x[0], 0.0, 1e-12);
  EXPECT_NEAR(result.slack, 0.5e-3, 1e-12);
}

TEST(QpSolver, RelaxesARowThatNothingCanSatisfy) {
  RigidProblem problem{Vec::Ones(6), Mat::Zero(3, 6), Vec::Constant(3, 1.0), {}};
  problem.A(1, 1) = 1.0;
  problem.A(2, 2) = 1.0;
  const QpResult result = SolveProblem(problem);
  EXPECT_EQ(result.status, QpStatus::kRelaxed);
  EXPECT_NEAR(result.slack, 1.0, 1e-9);
  for (int c = 0; c < 6; ++c) EXPECT_NEAR(result.x[c], 1.0, 1e-9);
}

/// A problem with soft rows: row i yields where weight[i] > 0, down to a core `depth[i]` inside.
struct CompliantProblem {
  RigidProblem problem;
  Vec weight;
  Vec depth;
  double force[6];
  int pushing = 0;

  QpResult Solve(std::vector<int> guess = {}, const Kernels& kernels = ActiveKernels()) {
    const int m = static_cast<int>(weight.size());
    const auto rows = static_cast<std::size_t>(std::max(16, (m + 15) & ~15));
    const AlignedColumns columns(3, rows);
    QpRows rigid = problem.Rows();
    YieldingEnergy soft;
    soft.yielding = {rigid, columns[0], nullptr, columns[1]};
    rigid.b = columns[2];
    for (int i = 0; i < static_cast<int>(rows); ++i) {
      columns[0][i] = i < m ? weight[i] : 0.0;
      columns[2][i] = i < m ? problem.b[i] - (weight[i] > 0.0 ? depth[i] : 0.0) : -1e300;
    }
    Energy* const energy = &soft;
    const double start[6] = {};
    const QpResult result = EnergySolver(rows, 0).Solve(kernels, problem.Target().data(), rigid,
                                                        {&energy, 1}, start, guess);
    pushing = soft.pushing;
    std::copy(soft.force.begin(), soft.force.end(), force);
    return result;
  }

  /// The same nearest-point problem with every eta_i / sqrt(c_i) as an unknown, for enumeration.
  RigidProblem Explicit() const {
    const int n = static_cast<int>(problem.t.size()), m = static_cast<int>(weight.size());
    const int soft = static_cast<int>((weight.array() > 0.0).count());
    RigidProblem out{Vec::Zero(n + soft), Mat::Zero(m + soft, n + soft), Vec(m + soft), {}};
    out.t.head(n) = problem.t;
    for (int i = 0, k = 0; i < m; ++i) {
      out.A.row(i).head(n) = problem.A.row(i);
      out.b[i] = problem.b[i];
      if (weight[i] == 0.0) continue;
      out.A(i, n + k) = 1.0 / std::sqrt(weight[i]);
      out.A.row(m + k).head(n) = problem.A.row(i);
      out.b[m + k] = problem.b[i] - depth[i];
      ++k;
    }
    return out;
  }

  /// As KktResidual [unit of b], with the gradient relative to the sum of weights and multipliers.
  double Residual(const QpResult& result) const {
    const Vec x = Eigen::Map<const Vec>(result.x, problem.t.size());
    Vec gradient = x - problem.t;
    double worst = 0.0, sum = 0.0;
    const auto core = [&](int i) { return problem.b[i] - (weight[i] > 0.0 ? depth[i] : 0.0); };
    const Vec told = Eigen::Map<const Vec>(force, problem.t.size());
    Vec sum_of_pushes = Vec::Zero(problem.t.size());
    int pushes = 0;
    for (int i = 0; i < weight.size(); ++i) {
      const double gap = problem.A.row(i).dot(x) - problem.b[i];
      if (gap < 0.0) {
        gradient += weight[i] * gap * problem.A.row(i).transpose();
        sum_of_pushes -= weight[i] * gap * problem.A.row(i).transpose();
        pushes += weight[i] > 0.0;
      }
      worst = std::max(worst, core(i) - result.slack - problem.A.row(i).dot(x));
    }
    for (int j = 0; j < result.active; ++j) {
      const auto a = problem.A.row(result.row[j]).transpose();
      gradient -= result.multiplier[j] * a;
      sum += result.multiplier[j];
      worst = std::max(worst, -result.multiplier[j]);
      worst = std::max(worst, std::abs(a.dot(x) + result.slack - core(result.row[j])));
    }
    if (result.status == QpStatus::kRelaxed) {
      worst = std::max(worst, std::abs(result.slack - kJamCompliance * sum));
    }
    const double scale = 1.0 + weight.sum() + sum;
    EXPECT_LT((told - sum_of_pushes).cwiseAbs().maxCoeff(), 1e-12 * scale);
    EXPECT_NEAR(pushes, pushing, 1);  // one row may lie on the boundary
    return std::max(worst, gradient.cwiseAbs().maxCoeff() / scale);
  }
};

CompliantProblem RandomCompliantProblem(Random& random, int n, int soft, int rigid, double stiffest,
                                        bool cores = false) {
  const int m = soft + rigid;
  CompliantProblem out{RandomProblem(random, n, m, true), Vec::Zero(m), Vec::Constant(m, 1e9), {}};
  for (int k = 0; k < soft; ++k) {
    // Soft and rigid rows alternate while both last.
    const int i = k < rigid ? 2 * k : rigid + k;
    out.weight[i] = std::pow(10.0, random.Uniform(-2.0, std::log10(stiffest)));
    out.problem.b[i] += random.Uniform(0.0, 1.0);
    if (cores) out.depth[i] = 1.0 + random.Uniform(0.0, 0.3);
  }
  return out;
}

TEST(CompliantQp, PutsASoftRowInSeriesWithTheCoupling) {
  CompliantProblem soft{{Vec::Zero(6), Mat::Zero(1, 6), Vec::Constant(1, 1e-3), {}},
                        Vec::Constant(1, 0.25),
                        Vec::Constant(1, 1.0),
                        {}};
  soft.problem.A(0, 1) = 1.0;
  const QpResult result = soft.Solve();
  EXPECT_EQ(result.status, QpStatus::kSolved);
  EXPECT_EQ(result.active, 0);
  // The coupling's stiffness is 1: springs of 1 and 1/4 share 1 mm.
  EXPECT_NEAR(result.x[1], 1e-3 * 0.25 / 1.25, 1e-18);
}

TEST(CompliantQp, AgreesWithEnumerationOverExplicitSlacks) {
  Random random(31);
  int pushed = 0, rigid_active = 0;
  for (int candidate = 0; candidate < 400; ++candidate) {
    const int n = candidate % 2 == 0 ? 6 : 3;
    CompliantProblem soft = RandomCompliantProblem(random, n, 1 + random.Below(4), random.Below(4),
                                                   1e3, candidate % 4 < 2);
    const QpResult result = soft.Solve();
    const RigidProblem explicit_problem = soft.Explicit();
    Vec oracle;
    ASSERT_TRUE(std::isfinite(LeastDistanceByEnumeration(explicit_problem, &oracle))) << candidate;
    ASSERT_EQ(result.status, QpStatus::kSolved) << candidate;
    EXPECT_LT((Eigen::Map<const Vec>(result.x, n) - oracle.head(n)).norm(), 1e-9) << candidate;
    EXPECT_LT(soft.Residual(result), 1e-12) << candidate;
    pushed += (oracle.tail(oracle.size() - n).array() > 1e-6).any();
    rigid_active += result.active > 0;
  }
  EXPECT_GT(pushed, 150);
  EXPECT_GT(rigid_active, 100);
}

TEST(CompliantQp, MeetsTheOptimalityConditionsWithThousandsOfSoftRows) {
  Random random(32);
  int most = 0;
  for (int candidate = 0; candidate < 60; ++candidate) {
    CompliantProblem soft = RandomCompliantProblem(random, candidate % 2 == 0 ? 6 : 3,
                                                   1 + random.Below(3000), random.Below(300), 1e5);
    const QpResult cold = soft.Solve();
    ASSERT_EQ(cold.status, QpStatus::kSolved) << candidate;
    EXPECT_LT(soft.Residual(cold), 1e-12) << candidate;
    const QpResult warm = soft.Solve({cold.row, cold.row + cold.active});
    EXPECT_LT(soft.Residual(warm), 1e-12) << candidate;
    most = std::max(most, cold.iterations);
  }
  EXPECT_LT(most, 400);
}

TEST(CompliantQp, RelaxesContradictoryRigidRowsBesideSoftOnes) {
  Random random(33);
  for (int candidate = 0; candidate < 100; ++candidate) {
    CompliantProblem soft = RandomCompliantProblem(random, 6, 50, 20, 100.0);
    // Two walls 1 mm closer than the tool is wide.
    for (const int side : {0, 1}) {
      soft.problem.A.row(1 + 2 * side).setZero();
      soft.problem.A(1 + 2 * side, 0) = side == 0 ? 1.0 : -1.0;
      soft.problem.b[1 + 2 * side] = 0.5e-3;
    }
    const QpResult result = soft.Solve();
    ASSERT_EQ(result.status, QpStatus::kRelaxed) << candidate;
    EXPECT_GE(result.slack, 0.5e-3 - 1e-9);
    EXPECT_LT(soft.Residual(result), 1e-8) << candidate;
  }
}

TEST(CompliantQp, AddsUpTheStiffnessOfRepeatedRows) {
  CompliantProblem soft{{Vec::Zero(3), Mat::Zero(1000, 3), Vec::Constant(1000, 1e-3), {}},
                        Vec::Constant(1000, 0.01),
                        Vec::Constant(1000, 1.0),
                        {}};
  soft.problem.A.col(2).setOnes();
  EXPECT_NEAR(soft.Solve().x[2], 1e-3 * 10.0 / 11.0, 1e-16);
}

TEST(CompliantQp, GivesTheSameBitsAtEverySimdLevel) {
  Random random(34);
  const Kernels* level[3];
  const int levels = AvailableKernels(level);
  for (int candidate = 0; candidate < 50; ++candidate) {
    CompliantProblem soft = RandomCompliantProblem(random, candidate % 2 == 0 ? 6 : 3, 500, 100,
                                                   1e4, candidate % 4 < 2);
    const QpResult expected = soft.Solve({}, *level[0]);
    for (int i = 1; i < levels; ++i) {
      const QpResult result = soft.Solve({}, *level[i]);
      for (int c = 0; c < static_cast<int>(soft.problem.t.size()); ++c) {
        EXPECT_EQ(result.x[c], expected.x[c]) << level[i]->name;
      }
      EXPECT_EQ(result.iterations, expected.iterations);
    }
  }
}

}  // namespace
}  // namespace palpate
