#include "scenes/tree/sphere.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/LU>

namespace palpate {
namespace {

/// Returns the sphere that all `count` balls touch from inside, with its centre in the affine hull
/// of theirs; a negative radius if there is none.
Sphere TangentSphere(const Sphere* const* b, int count) {
  const Sphere none{Vec3::Zero(), -1.0};
  if (count == 1) return *b[0];
  // |c - c_i| = R - r_i.  With y = c - c_0 and s = R - r_0, subtracting the first equation
  // leaves 2 d_i . y = |d_i|^2 + 2 s e_i - e_i^2, with d_i = c_i - c_0 and e_i = r_i - r_0: y is
  // linear in s.
  const int n = count - 1;
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> d(n, 3);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> constant(n);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> slope(n);
  for (int i = 0; i < n; ++i) {
    const Vec3 di = b[i + 1]->centre - b[0]->centre;
    const double e = b[i + 1]->radius - b[0]->radius;
    d.row(i) = di.transpose();
    constant[i] = 0.5 * (di.squaredNorm() - e * e);
    slope[i] = e;
  }
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> gram = d * d.transpose();
  const auto lu = gram.fullPivLu();
  if (!lu.isInvertible()) return none;
  const Vec3 y0 = d.transpose() * lu.solve(constant);
  const Vec3 y1 = d.transpose() * lu.solve(slope);
  // |y0 + y1 s| = s.
  const double qa = y1.squaredNorm() - 1.0;
  const double qb = 2.0 * y0.dot(y1);
  const double qc = y0.squaredNorm();
  double roots[2] = {-1.0, -1.0};
  if (std::abs(qa) < 1e-14) {
    if (qb != 0.0) roots[0] = -qc / qb;
  } else {
    const double discriminant = qb * qb - 4.0 * qa * qc;
    if (discriminant < 0.0) return none;
    const double q = -0.5 * (qb + std::copysign(std::sqrt(discriminant), qb));
    roots[0] = q / qa;
    if (q != 0.0) roots[1] = qc / q;
  }
  if (roots[1] >= 0.0 && (roots[0] < 0.0 || roots[1] < roots[0])) std::swap(roots[0], roots[1]);
  for (const double s : roots) {
    if (!(s >= 0.0)) continue;
    bool holds = true;  // false for roots of the squared equations with R < r_i
    for (int i = 0; i < count; ++i) holds &= s + b[0]->radius >= b[i]->radius * (1.0 - 1e-12);
    if (holds) return {b[0]->centre + y0 + y1 * s, s + b[0]->radius};
  }
  return none;
}

double Reach(const Sphere& from, const Sphere& ball) {
  return (ball.centre - from.centre).norm() + ball.radius;
}

}  // namespace

Sphere EnclosingSphere(const std::vector<Sphere>& balls) {
  const Sphere* basis[5];
  int size = 1;
  basis[0] = &*std::max_element(balls.begin(), balls.end(), [](const Sphere& a, const Sphere& b) {
    return a.radius < b.radius;
  });
  Sphere best = *basis[0];
  for (int round = 0; round < 100; ++round) {
    const Sphere* furthest = nullptr;
    double reach = best.radius * (1.0 + 1e-12);
    for (const Sphere& ball : balls) {
      if (const double r = Reach(best, ball); r > reach) {
        reach = r;
        furthest = &ball;
      }
    }
    if (furthest == nullptr) return best;
    // The new basis contains the ball that stuck out: try it with every subset of the old one.
    basis[size] = furthest;
    Sphere found{Vec3::Zero(), std::numeric_limits<double>::infinity()};
    const Sphere* found_basis[5] = {};
    int found_size = 0;
    for (int mask = 0; mask < (1 << size); ++mask) {
      const Sphere* part[5];
      int count = 0;
      part[count++] = furthest;
      for (int i = 0; i < size; ++i) {
        if (mask >> i & 1) part[count++] = basis[i];
      }
      if (count > 4) continue;
      const Sphere ball = TangentSphere(part, count);
      if (!(ball.radius >= 0.0) || !(ball.radius < found.radius)) continue;
      bool holds = true;
      for (int i = 0; i < size && holds; ++i) {
        holds = Reach(ball, *basis[i]) <= ball.radius * (1.0 + 1e-10);
      }
      if (!holds) continue;
      found = ball;
      found_size = count;
      std::copy(part, part + count, found_basis);
    }
    if (found_size == 0 || !(found.radius > best.radius)) break;  // only rounding: close enough
    best = found;
    size = found_size;
    std::copy(found_basis, found_basis + found_size, basis);
  }
  for (const Sphere& ball : balls) best.radius = std::max(best.radius, Reach(best, ball));
  return best;
}

SphereQuery::SphereQuery(std::vector<Sphere> balls) : balls_(std::move(balls)) {
  order_.resize(balls_.size());
  std::iota(order_.begin(), order_.end(), 0u);
  nodes_.reserve(balls_.size() + 1);
  nodes_.emplace_back();
  nodes_[0].end = static_cast<std::uint32_t>(balls_.size());
  Build(0);
}

void SphereQuery::Build(std::int32_t index) {
  Node node = nodes_[index];
  node.min = Vec3::Constant(std::numeric_limits<double>::infinity());
  node.max = -node.min;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::uint32_t i = node.begin; i < node.end; ++i) {
    const Sphere& ball = balls_[order_[i]];
    node.min = node.min.cwiseMin(ball.centre);
    node.max = node.max.cwiseMax(ball.centre);
    node.radius = std::max(node.radius, ball.radius);
    smallest = std::min(smallest, ball.radius);
  }
  if (node.end - node.begin > 4) {
    int axis = 0;
    const double extent = (node.max - node.min).maxCoeff(&axis);
    if (node.radius - smallest > extent) axis = 3;
    const auto key = [&](std::uint32_t i) {
      return axis < 3 ? balls_[i].centre[axis] : balls_[i].radius;
    };
    const std::uint32_t middle = node.begin + (node.end - node.begin) / 2;
    std::nth_element(order_.begin() + node.begin, order_.begin() + middle,
                     order_.begin() + node.end, [&](std::uint32_t a, std::uint32_t b) {
                       return key(a) < key(b) || (key(a) == key(b) && a < b);
                     });
    node.child = static_cast<std::int32_t>(nodes_.size());
    nodes_.resize(nodes_.size() + 2);
    nodes_[node.child].begin = node.begin;
    nodes_[node.child].end = nodes_[node.child + 1].begin = middle;
    nodes_[node.child + 1].end = node.end;
    nodes_[index] = node;
    Build(node.child);
    Build(node.child + 1);
  } else {
    nodes_[index] = node;
  }
}

double SphereQuery::Bound(const Node& node, const Vec3& p) const {
  return (node.min - p).cwiseMax(p - node.max).cwiseMax(0.0).norm() - node.radius;
}

template <class Visit>
void SphereQuery::Walk(const Vec3& p, double within, Visit visit) const {
  if (balls_.empty()) return;
  std::pair<double, std::int32_t> stack[64];  // the tree halves its balls, so it is never so deep
  int top = 0;
  stack[top++] = {Bound(nodes_[0], p), 0};
  while (top > 0) {
    const auto [bound, index] = stack[--top];
    if (!(bound < within)) continue;
    const Node& node = nodes_[index];
    if (node.child < 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        const Sphere& ball = balls_[order_[i]];
        const double distance = (p - ball.centre).norm() - ball.radius;
        if (distance < within) within = visit(order_[i], distance);
      }
      continue;
    }
    std::pair<double, std::int32_t> near{Bound(nodes_[node.child], p), node.child};
    std::pair<double, std::int32_t> far{Bound(nodes_[node.child + 1], p), node.child + 1};
    if (far.first < near.first) std::swap(near, far);
    if (far.first < within) stack[top++] = far;
    if (near.first < within) stack[top++] = near;
  }
}

SphereQuery::Hit SphereQuery::Nearest(const Vec3& p) const {
  Hit hit;
  Walk(p, hit.distance, [&](std::uint32_t ball, double distance) {
    hit = {ball, distance};
    return distance;
  });
  return hit;
}

std::vector<std::uint32_t> SphereQuery::NearestFew(const Vec3& p, std::size_t count,
                                                   double within) const {
  std::vector<std::pair<double, std::uint32_t>> few;  // sorted
  few.reserve(count + 1);
  Walk(p, within, [&](std::uint32_t ball, double distance) {
    const std::pair entry{distance, ball};
    few.insert(std::upper_bound(few.begin(), few.end(), entry), entry);
    if (few.size() > count) few.pop_back();
    return few.size() < count ? within : few.back().first;
  });
  std::vector<std::uint32_t> balls;
  for (const auto& [distance, ball] : few) balls.push_back(ball);
  return balls;
}

}  // namespace palpate
