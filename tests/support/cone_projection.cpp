#include "tests/support/cone_projection.h"

#include <algorithm>

#include <Eigen/Cholesky>

namespace palpate::test {
namespace {

using Real = long double;
using Mat6L = Eigen::Matrix<Real, 6, 6>;

constexpr int kSteps = 200;  // some ten are usual
constexpr int kHalvings = 40;
/// Of the gradient's terms: what is left is known to 1e-19 of b, which a slack of 1e-3 makes 1e-13.
constexpr Real kBalanced = 1e-11L;

}  // namespace

Vec6L LeftOfCone(std::span<const Vec6L> generators, const Vec6L& b, long double slack) {
  const Real weight = 1 / (slack * slack);
  const auto value = [&](const Vec6L& r) {
    Real sum = (r - b).squaredNorm();
    for (const Vec6L& a : generators) {
      const Real along = std::max<Real>(0, a.dot(r));
      sum += weight * along * along;
    }
    return sum;
  };
  Vec6L left = b;
  for (int step = 0; step < kSteps; ++step) {
    Vec6L gradient = left - b;
    Real terms = b.norm();
    Mat6L hessian = Mat6L::Identity();
    for (const Vec6L& a : generators) {
      const Real along = a.dot(left);
      if (along <= 0) continue;
      gradient += weight * along * a;
      terms += weight * along;
      hessian += weight * a * a.transpose();
    }
    if (gradient.norm() <= kBalanced * terms) break;
    const Vec6L way = -hessian.ldlt().solve(gradient);
    const Real before = value(left);
    Real part = 1;
    for (int i = 0; i < kHalvings && value(left + part * way) > before; ++i) part /= 2;
    left += part * way;
  }
  return left;
}

}  // namespace palpate::test
