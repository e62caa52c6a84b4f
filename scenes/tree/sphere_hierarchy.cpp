#include "scenes/tree/sphere_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include <Eigen/Eigenvalues>

#include "common/math/float_rounding.h"

namespace palpate {
namespace {

using Range = std::pair<std::size_t, std::size_t>;  ///< positions in the order of the leaves

constexpr int kRefinements = 20;  // rounds; most groups converge sooner
constexpr int kNeighbourRounds = 5;
constexpr int kNeighbours = 8;          // groups that a group exchanges leaves with
constexpr std::size_t kTradedAll = 64;  // groups up to this size exchange beyond their parent

/// Groups balls whose *centres* are close, wherever they touch the surface, because that makes
/// tight nodes: on both sides of an ear the maximal inner balls are nearly the same.
class Arranger {
 public:
  explicit Arranger(const std::vector<Sphere>& leaves) : leaves_(leaves), order_(leaves.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
  }

  SphereHierarchy Run() {
    std::size_t unit = 1;  // number of leaves below one lane of the present level
    while (unit * kTreeArity < leaves_.size()) unit *= kTreeArity;
    std::vector<std::vector<std::vector<Range>>> levels;  // levels, packets, lanes
    std::vector<Range> ranges{{0, leaves_.size()}};
    for (;; unit /= kTreeArity) {
      std::vector<Range> below;
      auto& packets = levels.emplace_back();
      for (const Range& range : ranges) {
        std::vector<Range>& lanes = packets.emplace_back();
        Split(range, unit, lanes);
        if (unit > 1) TradeAmong(lanes);
        below.insert(below.end(), lanes.begin(), lanes.end());
      }
      if (unit == 1) break;
      if (unit <= kTradedAll) TradeWithNeighbours(below);
      ranges = std::move(below);
    }
    SphereTree tree;
    tree.level_begin.push_back(0);
    for (const auto& packets : levels) {
      std::size_t child = 0;
      for (const std::vector<Range>& lanes : packets) {
        tree.packets.push_back(MakePacket(lanes, child));
        child += lanes.size();
      }
      tree.level_begin.push_back(static_cast<std::int32_t>(tree.packets.size()));
    }
    for (std::uint32_t i : order_) {
      tree.leaf_x.push_back(leaves_[i].centre.x());
      tree.leaf_y.push_back(leaves_[i].centre.y());
      tree.leaf_z.push_back(leaves_[i].centre.z());
      tree.leaf_radius.push_back(leaves_[i].radius);
    }
    return {std::move(tree), std::move(order_)};
  }

 private:
  const Vec3& Centre(std::size_t position) const { return leaves_[order_[position]].centre; }

  Vec3 Mean(Range range) const {
    Vec3 mean = Vec3::Zero();
    for (std::size_t i = range.first; i < range.second; ++i) mean += Centre(i);
    return mean / static_cast<double>(range.second - range.first);
  }

  /// Orders a range into lanes of `unit` leaves, with the rest in the last one.
  void Split(Range range, std::size_t unit, std::vector<Range>& lanes) {
    const std::size_t size = range.second - range.first;
    const std::size_t groups = (size + unit - 1) / unit;
    if (groups <= 1) {
      lanes.push_back(range);
      return;
    }
    const std::size_t middle = range.first + (groups + 1) / 2 * unit;
    Part(range, middle);
    Split({range.first, middle}, unit, lanes);
    Split({middle, range.second}, unit, lanes);
  }

  /// Divides a range in two, in the direction that gives the tighter balls.
  void Part(Range range, std::size_t middle) {
    const auto begin = order_.begin() + range.first;
    const auto end = order_.begin() + range.second;
    std::vector<std::uint32_t> best;
    double best_cost = std::numeric_limits<double>::infinity();
    for (const Vec3& direction : Directions(range)) {
      std::vector<std::uint32_t> trial(begin, end);
      const auto cut = trial.begin() + (middle - range.first);
      std::nth_element(trial.begin(), cut, trial.end(), [&](std::uint32_t a, std::uint32_t b) {
        const double x = leaves_[a].centre.dot(direction);
        const double y = leaves_[b].centre.dot(direction);
        return x < y || (x == y && a < b);
      });
      const double cost = Cost({trial.begin(), cut}) + Cost({cut, trial.end()});
      if (cost < best_cost) {
        best_cost = cost;
        best = std::move(trial);
      }
    }
    std::copy(best.begin(), best.end(), begin);
  }

  /// Returns the principal axes in both directions, because the smaller part may lie at either end.
  std::vector<Vec3> Directions(Range range) const {
    const Vec3 mean = Mean(range);
    Mat3 covariance = Mat3::Zero();
    for (std::size_t i = range.first; i < range.second; ++i) {
      const Vec3 d = Centre(i) - mean;
      covariance += d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance);
    std::vector<Vec3> directions;
    for (int k = 2; k >= 0; --k) {
      directions.push_back(solver.eigenvectors().col(k));
      directions.push_back(-solver.eigenvectors().col(k));
    }
    return directions;
  }

  /// Returns the number of leaves times the radius of a ball round them.
  double Cost(std::span<const std::uint32_t> group) const {
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 high = -low;
    for (std::uint32_t i : group) {
      low = low.cwiseMin((leaves_[i].centre.array() - leaves_[i].radius).matrix());
      high = high.cwiseMax((leaves_[i].centre.array() + leaves_[i].radius).matrix());
    }
    const Vec3 centre = 0.5 * (low + high);
    double radius = 0.0;
    for (std::uint32_t i : group) {
      radius = std::max(radius, (leaves_[i].centre - centre).norm() + leaves_[i].radius);
    }
    return static_cast<double>(group.size()) * radius;
  }

  /// Exchanges equal numbers of leaves between two groups while that reduces distances from their
  /// centres (k-means with fixed sizes).  Returns whether any leaf was exchanged.
  bool Trade(Range a, Range b) {
    const Vec3 mean_a = Mean(a);
    const Vec3 mean_b = Mean(b);
    const auto eager = [&](Range from, const Vec3& here, const Vec3& there) {
      std::vector<std::pair<double, std::size_t>> gains;  // negative, so that the best comes first
      for (std::size_t i = from.first; i < from.second; ++i) {
        gains.emplace_back((Centre(i) - there).squaredNorm() - (Centre(i) - here).squaredNorm(), i);
      }
      std::sort(gains.begin(), gains.end());
      return gains;
    };
    const auto from_a = eager(a, mean_a, mean_b);
    const auto from_b = eager(b, mean_b, mean_a);
    const double enough = -1e-9 * (mean_a - mean_b).squaredNorm();
    std::size_t traded = 0;
    while (traded < std::min(from_a.size(), from_b.size()) &&
           from_a[traded].first + from_b[traded].first < enough) {
      std::swap(order_[from_a[traded].second], order_[from_b[traded].second]);
      ++traded;
    }
    return traded > 0;
  }

  void TradeAmong(const std::vector<Range>& groups) {
    bool any = true;
    for (int round = 0; round < kRefinements && any; ++round) {
      any = false;
      for (std::size_t g = 0; g < groups.size(); ++g) {
        for (std::size_t h = g + 1; h < groups.size(); ++h) any |= Trade(groups[g], groups[h]);
      }
    }
  }

  /// Exchanges leaves across parents, so that boundaries of parents need not separate close leaves.
  void TradeWithNeighbours(const std::vector<Range>& groups) {
    for (int round = 0; round < kNeighbourRounds; ++round) {
      std::vector<Sphere> means;
      for (const Range& range : groups) means.push_back({Mean(range), 0.0});
      const SphereQuery query(means);
      for (std::uint32_t g = 0; g < groups.size(); ++g) {
        for (std::uint32_t h : query.NearestFew(means[g].centre, kNeighbours + 1)) {
          if (h != g) Trade(groups[g], groups[h]);
        }
      }
    }
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
        balls.push_back(leaves_[order_[i]]);
      }
      const Vec3 centre = EnclosingSphere(balls).centre;
      packet.x[lane] = RoundToFloat(centre.x());
      packet.y[lane] = RoundToFloat(centre.y());
      packet.z[lane] = RoundToFloat(centre.z());
      const Vec3 rounded(packet.x[lane], packet.y[lane], packet.z[lane]);
      double radius = 0.0;
      for (const Sphere& ball : balls) {
        radius = std::max(radius, (ball.centre - rounded).norm() + ball.radius);
      }
      radius *= 1.0 + 1e-15;  // the norm itself was rounded
      packet.radius[lane] = RoundToFloat(radius);
      if (packet.radius[lane] < radius) {
        packet.radius[lane] =
            std::nextafter(packet.radius[lane], std::numeric_limits<float>::infinity());
      }
      packet.child[lane] = static_cast<std::int32_t>(first_child + lane);
    }
    return packet;
  }

  const std::vector<Sphere>& leaves_;
  std::vector<std::uint32_t> order_;
};

}  // namespace

SphereHierarchy ArrangeLeaves(const std::vector<Sphere>& leaves) {
  return Arranger(leaves).Run();
}

}  // namespace palpate
