// The QP against oracles that share nothing with it: enumeration of all active sets in long double,
// and the Karush-Kuhn-Tucker conditions, which only the optimum of a convex problem meets.
#include "common/qp/nearest_point.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "tests/support/optimised.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;
using Real = long double;
using Vec = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
using Mat = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

constexpr int kN = 6;
/// Bounds on the residuals that rounding leaves: three to twenty times the worst of these problems,
/// which are the same on every machine.  Without the solver's polish they are 6e-15, 3e-14 and
/// 1e-10.
constexpr double kSolvedResidual = 4e-15;   // worst: 9e-16
constexpr double kRelaxedResidual = 3e-14;  // worst: 9e-15
constexpr double kFanResidual = 1e-11;      // worst: 6e-13, with rows that differ by 1e-14

/// min 1/2 |x - t|^2, A x >= b.
struct Problem {
  Vec t;
  Mat A;
  Vec b;

  int rows() const { return static_cast<int>(b.size()); }
};

template <int N = kN>
QpResultOf<N> SolverOf(const Problem& problem, const std::vector<int>& guess = {}) {
  const int m = problem.rows(), padded = std::max(16, (m + 15) & ~15);
  std::vector<double> storage(static_cast<std::size_t>((N + 1) * padded + 8), 0.0);
  const auto address = reinterpret_cast<std::uintptr_t>(storage.data());
  double* const base = storage.data() + (64 - address % 64) % 64 / sizeof(double);
  QpRowsOf<N> rows{};
  for (int c = 0; c < N; ++c) {
    for (int i = 0; i < m; ++i) base[c * padded + i] = static_cast<double>(problem.A(i, c));
    rows.a[c] = base + c * padded;
  }
  double* const b = base + N * padded;
  for (int i = 0; i < padded; ++i) b[i] = i < m ? static_cast<double>(problem.b[i]) : -1e300;
  rows.b = b;
  rows.count = m;
  double t[N];
  for (int c = 0; c < N; ++c) t[c] = static_cast<double>(problem.t[c]);
  return SolveNearestPoint(t, rows, guess.data(), static_cast<int>(guess.size()));
}

template <int N>
Vec PointOf(const QpResultOf<N>& result) {
  return Eigen::Map<const Eigen::Matrix<double, N, 1>>(result.x).template cast<Real>();
}

/// Largest violation of the optimality conditions, each over the size of its terms, so that rows of
/// any length count alike.
template <int N>
Real KktResidual(const Problem& problem, const QpResultOf<N>& result) {
  const Vec x = PointOf(result);
  Vec gradient = x - problem.t;
  Real worst = 0, sum = 0, pushes = 1 + problem.t.norm();
  for (int j = 0; j < result.active; ++j) {
    const Vec a = problem.A.row(result.row[j]).transpose();
    const Real u = result.multiplier[j], size = 1 + a.norm() * (1 + x.norm());
    gradient -= u * a;
    pushes += u * a.norm();
    sum += u;
    worst = std::max(worst, -u);
    worst = std::max(worst, std::abs(a.dot(x) + result.slack - problem.b[result.row[j]]) / size);
  }
  worst = std::max(worst, gradient.norm() / pushes);
  const Real slack =
      result.status == QpStatus::kRelaxed ? static_cast<Real>(kJamCompliance) * sum : Real{0};
  worst = std::max(worst, std::abs(result.slack - slack) / (1 + slack));
  for (int i = 0; i < problem.rows(); ++i) {
    const Vec a = problem.A.row(i).transpose();
    worst =
        std::max(worst, (problem.b[i] - result.slack - a.dot(x)) / (1 + a.norm() * (1 + x.norm())));
  }
  return worst;
}

template <int N>
void ExpectSound(const Problem& problem, const QpResultOf<N>& result, int trial) {
  ASSERT_NE(result.status, QpStatus::kIterationLimit) << trial;
  ASSERT_LE(result.active, N + 1) << trial;
  const std::set<int> distinct(result.row, result.row + result.active);
  EXPECT_EQ(distinct.size(), static_cast<std::size_t>(result.active)) << trial;
  for (const int row : distinct) ASSERT_TRUE(row >= 0 && row < problem.rows()) << trial;
  EXPECT_EQ(result.status == QpStatus::kRelaxed, result.slack > 0.0) << trial;
}

/// The optimum by trying every set of rows as equalities; nullopt: no point satisfies all rows.
std::optional<Vec> ByEnumeration(const Problem& problem) {
  const int m = problem.rows();
  const auto n = problem.t.size();
  // A set is optimal if its multipliers are not negative and the other rows hold.  The optimum is
  // unique, so the first set found gives it.
  for (unsigned set = 0; set < (1u << m); ++set) {
    const int k = __builtin_popcount(set);
    if (k > n) continue;
    Mat A(k, n);
    Vec b(k);
    for (int i = 0, r = 0; i < m; ++i) {
      if ((set >> i & 1u) == 0) continue;
      A.row(r) = problem.A.row(i) / std::max(problem.A.row(i).norm(), Real{1e-300L});
      b[r++] = problem.b[i] / std::max(problem.A.row(i).norm(), Real{1e-300L});
    }
    Vec x = problem.t;
    if (k > 0) {
      const Eigen::FullPivLU<Mat> gram(A * A.transpose());
      // Dependent sets are left out: an independent set has the same point.
      if (gram.rank() < k || gram.rcond() < 1e-14L) continue;
      const Vec u = gram.solve(b - A * problem.t);
      if (u.minCoeff() < -1e-13L) continue;
      x += A.transpose() * u;
    }
    bool holds = true;
    for (int i = 0; i < m && holds; ++i) {
      holds = problem.A.row(i).dot(x) - problem.b[i] >
              -1e-12L * (1 + problem.A.row(i).norm() * (1 + x.norm()));
    }
    if (holds) return x;
  }
  return std::nullopt;
}

Vec Uniform(Random& random, double half) {
  Vec v(kN);
  for (int c = 0; c < kN; ++c) v[c] = random.Uniform(-half, half);
  return v;
}

/// Rows of every awkward kind around a point that satisfies them all with some room, or around
/// none.  Every number is a double, so that solver and oracle read the same.
Problem UglyProblem(Random& random, int m, bool feasible) {
  Problem problem{Uniform(random, 1.0), Mat(m, kN), Vec(m)};
  const Vec inside = Uniform(random, 1.0);
  for (int i = 0; i < m; ++i) {
    Vec a = Uniform(random, 1.0).normalized();
    const int other = i > 0 ? random.Below(i) : 0;
    switch (random.Below(8)) {
      case 0:  // a copy of a row, or its opposite
        if (i > 0) a = (random.Below(2) == 0 ? 1 : -1) * problem.A.row(other).transpose();
        break;
      case 1:  // along an axis, as walls are
        a.setZero();
        a[random.Below(kN)] = random.Below(2) == 0 ? 1 : -1;
        break;
      case 2:  // long or short
        a *= std::pow(10.0, random.Uniform(-3.0, 3.0));
        break;
      case 3:  // a combination of other rows
        if (i > 1) a = (problem.A.row(other) + problem.A.row(i - 1)).transpose();
        break;
      case 4:  // translation alone, as from a single sphere
        a.tail<3>().setZero();
        break;
      default:
        break;
    }
    problem.A.row(i) = a.cast<double>().cast<Real>().transpose();
    const Real room = feasible ? random.Uniform(0.0, 0.3) : random.Uniform(-0.3, 0.1);
    problem.b[i] =
        static_cast<double>(problem.A.row(i).dot(inside) - room * problem.A.row(i).norm());
  }
  problem.t = problem.t.cast<double>().cast<Real>();
  return problem;
}

TEST(NearestPoint, IsTheOneThatEnumerationFindsOrRelaxesWhereItFindsNone) {
  Random random(101);
  int solved = 0, relaxed = 0, touched[kN + 1] = {};
  const int trials = test::kOptimised ? 3000 : 300;
  for (int trial = 0; trial < trials; ++trial) {
    const Problem problem = UglyProblem(random, 1 + random.Below(9), trial % 3 != 0);
    const QpResult result = SolverOf(problem);
    ASSERT_NO_FATAL_FAILURE(ExpectSound(problem, result, trial));
    const std::optional<Vec> truth = ByEnumeration(problem);
    ASSERT_EQ(result.status == QpStatus::kSolved, truth.has_value()) << trial;
    if (truth) {
      ++solved;
      ++touched[std::min(result.active, kN)];
      EXPECT_LT((PointOf(result) - *truth).norm(), 1e-11) << trial;
      EXPECT_LT(KktResidual(problem, result), kSolvedResidual) << trial;
      continue;
    }
    ++relaxed;
    EXPECT_LT(KktResidual(problem, result), kRelaxedResidual) << trial;
    // The same problem with eta / sqrt(c) as one more unknown.
    const Real root = std::sqrt(static_cast<Real>(kJamCompliance));
    Problem larger{Vec::Zero(kN + 1), Mat(problem.rows(), kN + 1), problem.b};
    larger.t.head(kN) = problem.t;
    larger.A << problem.A, Vec::Constant(problem.rows(), root);
    const std::optional<Vec> oracle = ByEnumeration(larger);
    ASSERT_TRUE(oracle) << trial << ": a slack satisfies any rows";
    // A compliance of 1e-5 magnifies the oracle's tolerance for rounding, 1e-12, a millionfold.
    const Real slack = root * (*oracle)[kN];
    EXPECT_LT(std::abs(result.slack - slack) / (1 + slack), 1e-6) << trial;
    EXPECT_LT((PointOf(result) - oracle->head(kN)).norm(), 1e-6) << trial;
  }
  // Every kind occurred.
  EXPECT_GT(solved, trials / 3);
  EXPECT_GT(relaxed, trials / 30);
  for (int active = 0; active <= 4; ++active) EXPECT_GT(touched[active], 0) << active;
}

TEST(NearestPoint, MeetsTheConditionsOfOptimalityOnThousandsOfRowsThatAPointSatisfies) {
  Random random(102);
  const int trials = test::kOptimised ? 400 : 40;
  int moved = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const Problem problem = UglyProblem(random, 1 + random.Below(3000), true);
    const QpResult result = SolverOf(problem);
    ASSERT_NO_FATAL_FAILURE(ExpectSound(problem, result, trial));
    ASSERT_EQ(result.status, QpStatus::kSolved) << trial;
    EXPECT_LT(KktResidual(problem, result), kSolvedResidual) << trial;
    moved += result.active > 0;
  }
  EXPECT_GT(moved, trials / 2);
}

/// Rows of which each names at most two of N / 6 blocks of unknowns, as contacts of two bodies do.
template <int N>
Problem BlockProblem(Random& random, int m, bool feasible) {
  Problem problem{Vec::Zero(N), Mat::Zero(m, N), Vec(m)};
  Vec inside(N);
  for (int block = 0; block < N / 6; ++block) {
    problem.t.segment<6>(6 * block) = Uniform(random, 1.0);
    inside.segment<6>(6 * block) = Uniform(random, 1.0);
  }
  for (int i = 0; i < m; ++i) {
    const int one = random.Below(N / 6), two = random.Below(N / 6);
    const int other = i > 0 ? random.Below(i) : 0;
    problem.A.row(i).segment<6>(6 * one) = Uniform(random, 1.0).transpose();
    if (random.Below(3) > 0) {
      // Equal and opposite for the translations, as contacts push.
      problem.A.row(i).segment<6>(6 * two) = Uniform(random, 1.0).transpose();
      problem.A.row(i).segment<3>(6 * two) = -problem.A.row(i).segment<3>(6 * one);
    }
    if (i > 0 && random.Below(6) == 0) problem.A.row(i) = problem.A.row(other);
    if (i > 0 && random.Below(6) == 0) problem.A.row(i) = -problem.A.row(other);
    problem.A.row(i) = problem.A.row(i).cast<double>().cast<Real>().eval();
    const Real room = feasible ? random.Uniform(0.0, 0.3) : random.Uniform(-0.3, 0.1);
    problem.b[i] =
        static_cast<double>(problem.A.row(i).dot(inside) - room * problem.A.row(i).norm());
  }
  problem.t = problem.t.cast<double>().cast<Real>();
  return problem;
}

template <int N>
void SolveBlocks(std::uint64_t seed, Real most, Real most_relaxed) {
  Random random(seed);
  int several = 0, relaxed = 0;
  for (int trial = 0; trial < (test::kOptimised ? 1500 : 60); ++trial) {
    const Problem problem = BlockProblem<N>(random, 1 + random.Below(120), trial % 4 != 0);
    const QpResultOf<N> result = SolverOf<N>(problem);
    ASSERT_NO_FATAL_FAILURE(ExpectSound(problem, result, trial));
    if (trial % 4 != 0) ASSERT_EQ(result.status, QpStatus::kSolved) << trial;
    relaxed += result.status == QpStatus::kRelaxed ? 1 : 0;
    several += result.active > N / 2 ? 1 : 0;
    EXPECT_LT(KktResidual(problem, result),
              result.status == QpStatus::kSolved ? most : most_relaxed)
        << trial;
    const QpResultOf<N> warm = SolverOf<N>(problem, {result.row, result.row + result.active});
    EXPECT_LT((PointOf(warm) - PointOf(result)).norm(), 1e-12) << trial;
  }
  EXPECT_GT(several, test::kOptimised ? 100 : 1);
  EXPECT_GT(relaxed, test::kOptimised ? 100 : 1);
}

TEST(NearestPoint, MeetsTheConditionsOfOptimalityForSeveralBlocks) {
  SolveBlocks<12>(107, 2 * kSolvedResidual, 4 * kRelaxedResidual);
  SolveBlocks<24>(108, 2 * kSolvedResidual, 4 * kRelaxedResidual);
}

TEST(NearestPoint, SolvesFansOfNearlyParallelRowsThatAPointSatisfiesWithRoom) {
  Random random(103);
  for (int trial = 0; trial < 400; ++trial) {
    Problem problem{Uniform(random, 1.0), Mat(60, kN), Vec(60)};
    const Vec inside = Uniform(random, 0.5);
    for (int i = 0; i < 60; ++i) {
      Vec a = Uniform(random, 1.0);
      if (i >= 6) {
        a = problem.A.row(i % 6).transpose() +
            static_cast<Real>(std::pow(10.0, -random.Uniform(1.0, 14.0))) * a;
      }
      problem.A.row(i) = a.normalized().cast<double>().cast<Real>().transpose();
      problem.b[i] = static_cast<double>(problem.A.row(i).dot(inside)) - 0.01;
    }
    problem.t = problem.t.cast<double>().cast<Real>();
    const QpResult result = SolverOf(problem);
    ASSERT_NO_FATAL_FAILURE(ExpectSound(problem, result, trial));
    ASSERT_EQ(result.status, QpStatus::kSolved) << trial;
    EXPECT_LT(KktResidual(problem, result), kFanResidual) << trial;
  }
}

TEST(NearestPoint, IsTheSameFromAnyGuess) {
  Random random(104);
  for (int trial = 0; trial < 500; ++trial) {
    const Problem problem = UglyProblem(random, 1 + random.Below(200), true);
    const QpResult cold = SolverOf(problem);
    std::vector<int> guess;
    for (int i = random.Below(20); i > 0; --i) guess.push_back(random.Below(problem.rows()));
    if (random.Below(2) == 0) guess.insert(guess.end(), cold.row, cold.row + cold.active);
    const QpResult warm = SolverOf(problem, guess);
    ASSERT_NO_FATAL_FAILURE(ExpectSound(problem, warm, trial));
    EXPECT_LT(KktResidual(problem, warm), kSolvedResidual) << trial;
    EXPECT_LT((PointOf(warm) - PointOf(cold)).norm(), 1e-12) << trial;
    const QpResult known = SolverOf(problem, {cold.row, cold.row + cold.active});
    EXPECT_LE(known.iterations, cold.iterations) << trial;
  }
}

TEST(NearestPoint, StaysAtATargetThatSatisfiesEveryRowToTheBit) {
  Random random(105);
  for (int trial = 0; trial < 200; ++trial) {
    Problem problem = UglyProblem(random, 1 + random.Below(100), true);
    for (int i = 0; i < problem.rows(); ++i) {
      problem.b[i] = static_cast<double>(problem.A.row(i).dot(problem.t)) - 1e-6;
    }
    const QpResult result = SolverOf(problem);
    EXPECT_EQ(result.active, 0);
    EXPECT_EQ(PointOf(result), problem.t);
  }
  EXPECT_EQ(SolverOf({Vec::Ones(kN), Mat(0, kN), Vec(0)}).status, QpStatus::kSolved) << "no rows";
}

TEST(NearestPoint, IsFiniteHoweverShortARowIs) {
  for (int exponent = 0; exponent >= -320; --exponent) {
    Problem problem{Vec::Constant(kN, -0.125), Mat::Zero(2, kN), Vec::Zero(2)};
    problem.A(0, 2) = std::pow(Real{10}, exponent);
    problem.b[0] = 15.875;
    problem.A(1, 0) = 0.5;
    for (const std::vector<int>& guess : {std::vector<int>{}, {0}, {1, 0}}) {
      const QpResult result = SolverOf(problem, guess);
      for (const double x : result.x) ASSERT_TRUE(std::isfinite(x)) << exponent;
      for (int k = 0; k < result.active; ++k) ASSERT_TRUE(std::isfinite(result.multiplier[k]));
      // A row too short to be solved for is a zero row, and asks for the impossible.
      EXPECT_EQ(result.status, exponent > -75 ? QpStatus::kSolved : QpStatus::kRelaxed) << exponent;
    }
  }
}

}  // namespace
}  // namespace palpate
