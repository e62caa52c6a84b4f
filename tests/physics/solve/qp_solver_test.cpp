#include <cmath>
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

/// Rows that some point satisfies.
RigidProblem RandomProblem(Random& random, int n, int m) {
  RigidProblem problem{Vec(n), Mat(m, n), Vec(m), {}};
  Vec inside(n);
  for (int c = 0; c < n; ++c) {
    problem.t[c] = random.Uniform(-1.0, 1.0);
    inside[c] = random.Uniform(-1.0, 1.0);
  }
  for (int i = 0; i < m; ++i) {
    for (int c = 0; c < n; ++c) problem.A(i, c) = random.Uniform(-1.0, 1.0);
    problem.A.row(i).normalize();
    problem.b[i] = problem.A.row(i).dot(inside) - random.Uniform(0.0, 0.3);
  }
  return problem;
}

/// A problem with soft rows: row i yields where weight[i] > 0, down to a core `depth[i]` inside.
struct CompliantProblem {
  RigidProblem problem;
  Vec weight;
  Vec depth;
  double force[6];
  int pushing = 0;

  QpResult Solve(std::vector<int> guess = {}) {
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
    const QpResult result = EnergySolver(rows, 0).Solve(ActiveKernels(), problem.Target().data(),
                                                        rigid, {&energy, 1}, start, guess);
    pushing = soft.pushing;
    std::copy(soft.force.begin(), soft.force.end(), force);
    return result;
  }

  /// Largest violation of the Karush-Kuhn-Tucker conditions, which are sufficient for the optimum
  /// [unit of b], with the gradient relative to the sum of weights and multipliers.  Rows may be
  /// relaxed by a common `slack` with compliance c.
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
  CompliantProblem out{RandomProblem(random, n, m), Vec::Zero(m), Vec::Constant(m, 1e9), {}};
  for (int k = 0; k < soft; ++k) {
    // Soft and rigid rows alternate while both last.
    const int i = k < rigid ? 2 * k : rigid + k;
    out.weight[i] = std::pow(10.0, random.Uniform(-2.0, std::log10(stiffest)));
    out.problem.b[i] += random.Uniform(0.0, 1.0);
    if (cores) out.depth[i] = 1.0 + random.Uniform(0.0, 0.3);
  }
  return out;
}

TEST(CompliantQp, MeetsTheOptimalityConditionsWithAFewAndWithThousandsOfSoftRows) {
  Random random(32);
  int most = 0;
  for (int candidate = 0; candidate < 400; ++candidate) {
    const bool many = candidate % 4 == 0;
    const int soft_rows = 1 + random.Below(many ? 3000 : 4),
              rigid_rows = random.Below(many ? 300 : 4);
    CompliantProblem soft =
        RandomCompliantProblem(random, candidate % 2 == 0 ? 6 : 3, soft_rows, rigid_rows,
                               many ? 1e5 : 1e3, candidate % 3 == 0);
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

}  // namespace
}  // namespace palpate
