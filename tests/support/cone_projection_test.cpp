#include "tests/support/cone_projection.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace palpate::test {
namespace {

Vec6L RandomUnit(Random& random) {
  Vec6L v;
  for (int i = 0; i < 6; ++i) v[i] = random.Uniform(-1.0, 1.0);
  return v.normalized();
}

/// What the best of all sets of generators leaves, by brute force over the stacked least squares.
Vec6L LeftOfTheBest(const std::vector<Vec6L>& generators, const Vec6L& b, long double slack) {
  using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;
  Vec6L left = b;
  long double least = b.squaredNorm();
  for (unsigned set = 1; set < 1u << generators.size(); ++set) {
    const int n = std::popcount(set);
    Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic> A(6 + n, n);
    A.bottomRows(n) =
        slack * Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>::Identity(n, n);
    for (int i = 0, column = 0; i < static_cast<int>(generators.size()); ++i) {
      if ((set >> i & 1u) != 0) A.col(column++).head<6>() = generators[static_cast<std::size_t>(i)];
    }
    Vector stacked = Vector::Zero(6 + n);
    stacked.head<6>() = b;
    const Vector x = A.householderQr().solve(stacked);
    const Vector off = stacked - A * x;
    if (x.minCoeff() < 0 || off.squaredNorm() >= least) continue;
    least = off.squaredNorm();
    left = off.head<6>();
  }
  return left;
}

TEST(ConeProjection, LeavesWhatTheBestOfAllSetsOfGeneratorsLeaves) {
  Random random(11);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Vec6L> generators;
    for (int i = random.Below(8); i >= 0; --i) generators.push_back(RandomUnit(random));
    // Repeated, nearly repeated and opposite ones.
    generators.push_back(generators.front());
    generators.push_back((generators.front() + 1e-9L * RandomUnit(random)).normalized());
    if (trial % 3 == 0) generators.push_back(-generators.back());
    const Vec6L b = random.Uniform(0.0, 10.0) * RandomUnit(random);
    const Vec6L left = LeftOfCone(generators, b);
    EXPECT_LT(static_cast<double>((left - LeftOfTheBest(generators, b, 1e-3L)).norm()), 1e-9)
        << trial;
  }
}

TEST(ConeProjection, MakesNoWedgeOfTwoWallsThatAreParallelUpToRounding) {
  Vec6L across = Vec6L::Zero();
  across[1] = 1;
  for (const long double angle : {1e-9L, 1e-5L, 0.02L}) {
    Vec6L wall = Vec6L::Zero(), other = wall;
    wall[0] = 1;
    other[0] = -std::cos(angle);
    other[1] = std::sin(angle);
    const double left = static_cast<double>(LeftOfCone(std::vector{wall, other}, across).norm());
    // Of a right angle: 1 / (1 + (angle / slack)^2 / 2)
    EXPECT_NEAR(left, 1 / (1 + static_cast<double>(angle * angle) * 0.5e6), 1e-3) << angle;
  }
}

}  // namespace
}  // namespace palpate::test
