#include "scenes/sphere_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Eigenvalues>

namespace palpate {
namespace {

using Range = std::pair<std::size_t, std::size_t>;
using Feature = Eigen::Matrix<double, 7, 1>;  ///< centre, touching point, radius

class Arranger {
 public:
  explicit Arranger(const std::vector<LeafSphere>& leaves)
      : leaves_(leaves), order_(leaves.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    features_.reserve(leaves.size());
    for (const LeafSphere& l : leaves) {
      Feature f;
      f << l.ball.centre, l.touch, l.ball.radius;
      features_.push_back(f);
    }
  }

  SphereHierarchy Run() {
    std::size_t capacity = kTreeArity;  // leaves below one packet of the present level
    while (capacity < leaves_.size()) capacity *= kTreeArity;
    SphereTree tree;
    tree.level_begin.push_back(0);
    std::vector<Range> packets{{0, leaves_.size()}};
    for (;; capacity /= kTreeArity) {
      std::vector<Range> below;
      for (const Range& range : packets) {
        std::vector<Range> lanes;
        Split(range, capacity / kTreeArity, lanes);
        const bool last = capacity == kTreeArity;
        tree.packets.push_back(MakePacket(lanes, last ? range.first : below.size()));
        below.insert(below.end(), lanes.begin(), lanes.end());
      }
      tree.level_begin.push_back(static_cast<std::int32_t>(tree.packets.size()));
      if (capacity == kTreeArity) break;
      packets = std::move(below);
    }
    for (std::uint32_t i : order_) {
      const Sphere& ball = leaves_[i].ball;
      tree.leaf_x.push_back(ball.centre.x());
      tree.leaf_y.push_back(ball.centre.y());
      tree.leaf_z.push_back(ball.centre.z());
      tree.leaf_radius.push_back(ball.radius);
    }
    return {std::move(tree), std::move(order_)};
  }

 private:
  /// Orders a range into lanes of `unit` leaves, the last one with the rest.
  void Split(Range range, std::size_t unit, std::vector<Range>& lanes) {
    const std::size_t size = range.second - range.first;
    const std::size_t groups = (size + unit - 1) / unit;
    if (groups <= 1) {
      lanes.push_back(range);
      return;
    }
    const std::size_t left = (groups / 2 + (groups > 2 && groups % 2)) * unit;
    const std::size_t middle = range.first + left;
    Part(range, middle);
    Split({range.first, middle}, unit, lanes);
    Split({middle, range.second}, unit, lanes);
  }

  /// Parts a range in two along the direction that gives the tightest balls.
  void Part(Range range, std::size_t middle) {
    const auto begin = order_.begin() + range.first;
    const auto end = order_.begin() + range.second;
    std::vector<std::uint32_t> best;
    double best_cost = std::numeric_limits<double>::infinity();
    std::vector<std::uint32_t> trial;
    for (const Feature& direction : Directions(range)) {
      for (const double sign : {1.0, -1.0}) {
        trial.assign(begin, end);
        std::nth_element(trial.begin(), trial.begin() + (middle - range.first), trial.end(),
                         [&](std::uint32_t a, std::uint32_t b) {
                           const double x = sign * features_[a].dot(direction);
                           const double y = sign * features_[b].dot(direction);
                           return x < y || (x == y && a < b);
                         });
        const auto cut = trial.begin() + (middle - range.first);
        const double cost = Cost(trial.begin(), cut) + Cost(cut, trial.end());
        if (cost < best_cost) {
          best_cost = cost;
          best = trial;
        }
        if (2 * (middle - range.first) == range.second - range.first) break;  // equal parts
      }
    }
    std::copy(best.begin(), best.end(), begin);
  }

  std::vector<Feature> Directions(Range range) const {
    Feature mean = Feature::Zero();
    for (std::size_t i = range.first; i < range.second; ++i) mean += features_[order_[i]];
    mean /= static_cast<double>(range.second - range.first);
    Eigen::Matrix<double, 7, 7> covariance = Eigen::Matrix<double, 7, 7>::Zero();
    for (std::size_t i = range.first; i < range.second; ++i) {
      const Feature d = features_[order_[i]] - mean;
      covariance += d * d.transpose();
    }
    std::vector<Feature> directions;
    for (const int block : {0, 3}) {
      const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance.block<3, 3>(block, block));
      for (int k = 2; k >= 0; --k) {
        Feature f = Feature::Zero();
        f.segment<3>(block) = solver.eigenvectors().col(k);
        directions.push_back(f);
      }
    }
    directions.push_back(Feature::Unit(6));
    return directions;
  }

  template <class It>
  double Cost(It begin, It end) const {
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 high = -low;
    for (It i = begin; i != end; ++i) {
      const Sphere& b = leaves_[*i].ball;
      low = low.cwiseMin((b.centre.array() - b.radius).matrix());
      high = high.cwiseMax((b.centre.array() + b.radius).matrix());
    }
    const Vec3 centre = 0.5 * (low + high);
    double radius = 0.0;
    for (It i = begin; i != end; ++i) {
      const Sphere& b = leaves_[*i].ball;
      radius = std::max(radius, (b.centre - centre).norm() + b.radius);
    }
    return static_cast<double>(end - begin) * radius;
  }

  SpherePacket MakePacket(const std::vector<Range>& lanes, std::size_t first_child) const {
    SpherePacket packet;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (int lane = 0; lane < kTreeArity; ++lane) {
      packet.x[lane] = packet.y[lane] = packet.z[lane] = packet.radius[lane] = nan;
      packet.child[lane] = -1;
      if (lane >= static_cast<int>(lanes.size())) continue;
      std::vector<Sphere> balls;
      for (std::size_t i = lanes[lane].first; i < lanes[lane].second; ++i) {
        balls.push_back(leaves_[order_[i]].ball);
      }
      const Vec3 centre = EnclosingSphere(balls).centre;
      packet.x[lane] = static_cast<float>(centre.x());
      packet.y[lane] = static_cast<float>(centre.y());
      packet.z[lane] = static_cast<float>(centre.z());
      const Vec3 rounded(packet.x[lane], packet.y[lane], packet.z[lane]);
      double radius = 0.0;
      for (const Sphere& ball : balls) {
        radius = std::max(radius, (ball.centre - rounded).norm() + ball.radius);
      }
      radius *= 1.0 + 1e-15;  // the norm itself was rounded
      packet.radius[lane] = static_cast<float>(radius);
      if (packet.radius[lane] < radius) {
        packet.radius[lane] =
            std::nextafter(packet.radius[lane], std::numeric_limits<float>::infinity());
      }
      packet.child[lane] = static_cast<std::int32_t>(first_child + lane);
    }
    return packet;
  }

  const std::vector<LeafSphere>& leaves_;
  std::vector<Feature> features_;
  std::vector<std::uint32_t> order_;
};

}  // namespace

SphereHierarchy ArrangeLeaves(const std::vector<LeafSphere>& leaves) {
  return Arranger(leaves).Run();
}

}  // namespace palpate
