#include "scenes/tree/balanced_balls.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include <Eigen/Cholesky>

namespace palpate {
namespace {

constexpr double kDepth = 0.15;        // of the spacing
constexpr double kLost = 0.3;          // relative force error at which a sample's cost saturates
constexpr double kProtrusion = 0.025;  // of the spacing
constexpr double kLargest = 10.0;      // spacings
constexpr int kRounds = 12;
constexpr int kMovingRounds = 8;  // rounds in which balls are also moved to where they help more
constexpr std::uint32_t kStride = 2;  // of the samples, in these rounds
constexpr double kMovedShare = 0.04;  // of the balls, each round
constexpr std::size_t kNear = 4;      // nearest balls considered for each sample
constexpr std::uint32_t kNone = 0xffffffffu;
constexpr std::uint32_t kFewestSamples = 4;  // a ball has four unknowns
constexpr int kTrials = 4;                   // per step, shorter and shorter
constexpr double kDamping = 0.01;
// Share of a cell's cost that a second ball in it saves: half of the area has half of tilt^2.
constexpr double kGainOfSplit = 0.5;

using Vec4 = Eigen::Vector4d;
using Mat4 = Eigen::Matrix4d;

double Dull(double squared) {
  return squared / (1.0 + squared / (kLost * kLost));
}

/// Returns the weight in a least-squares step of a residual whose square is `squared`: the
/// slope of Dull.
double DullSlope(double squared) {
  const double w = 1.0 / (1.0 + squared / (kLost * kLost));
  return w * w;
}

class Balancer {
 public:
  Balancer(const BallsToBalance& work, std::vector<Sphere>& balls)
      : work_(work),
        balls_(balls),
        depth_(kDepth * work.spacing),
        protrusion_(kProtrusion * work.spacing),
        largest_(kLargest * work.spacing) {}

  void Run(const std::function<void(double)>& done) {
    std::vector<Sphere> best;
    double best_cost = std::numeric_limits<double>::infinity();
    for (int round = 0; round <= kRounds; ++round) {
      const bool moving = round < kMovingRounds;
      if (round == kMovingRounds) best_cost = std::numeric_limits<double>::infinity();
      stride_ = moving ? kStride : 1;
      const double cost = Assign();
      if (cost < best_cost) {
        best_cost = cost;
        best = balls_;
      }
      if (round == kRounds) break;
      fresh_.assign(balls_.size(), false);
      if (moving) Move();
      for (std::uint32_t b = 0; b < balls_.size(); ++b) Fit(b);
      done(double(round + 1) / kRounds);
    }
    balls_ = std::move(best);
  }

 private:
  double ErrorSquared(const Sphere& ball, const SurfaceSample& s) const {
    const Vec3 d = s.point - ball.centre;
    const double length = d.norm();
    if (!(length > 0.0)) return std::numeric_limits<double>::max();
    const double offset = (ball.radius + work_.probe - length) / depth_;
    return offset * offset + (d / length - s.outward).squaredNorm();
  }

  /// Returns the height of the union over the surface, minus the same for any ball.
  double Offset(const Sphere& ball, const SurfaceSample& s) const {
    return ball.radius - (s.point - ball.centre).norm();
  }

  /// Returns the cost of the samples that ball b is near to, if it were `ball`.  At each sample the
  /// outermost of its near balls is felt.
  double Cost(const Sphere& ball, std::uint32_t b) const {
    double sum = 0.0;
    for (const std::uint32_t s : NearTo(b)) {
      const SurfaceSample& sample = work_.samples[s];
      const Sphere* felt = &ball;
      double outermost = Offset(ball, sample);
      for (const std::uint32_t other : near_[s]) {
        if (other == b || other == kNone) continue;
        const double offset = Offset(balls_[other], sample);
        if (offset > outermost) {
          outermost = offset;
          felt = &balls_[other];
        }
      }
      sum += Dull(ErrorSquared(*felt, sample));
    }
    return sum;
  }

  /// Returns the cost of the samples at which ball b is felt.
  double CostWhereFelt(std::uint32_t b) const {
    double sum = 0.0;
    for (const std::uint32_t s : FeltAt(b)) {
      sum += Dull(ErrorSquared(balls_[b], work_.samples[s]));
    }
    return sum;
  }

  std::span<const std::uint32_t> NearTo(std::uint32_t b) const {
    return {member_.data() + begin_[b], member_.data() + begin_[b + 1]};
  }
  std::span<const std::uint32_t> FeltAt(std::uint32_t b) const { return NearTo(b).first(felt_[b]); }

  /// Finds for each sample its nearest balls, the outermost first, which is felt; and for each ball
  /// the samples that it is near to, beginning with those at which it is felt.
  /// @returns the mean cost.
  double Assign() {
    const SphereQuery query(balls_);
    const std::size_t count = work_.samples.size();
    loss_.assign(balls_.size(), 0.0);
    felt_.assign(balls_.size(), 0);
    begin_.assign(balls_.size() + 1, 0);
    if (near_.empty()) near_.resize(count, Unknown());
    double total = 0.0;
    std::size_t looked_at = 0;
    for (std::size_t s = 0; s < count; s += stride_, ++looked_at) {
      const SurfaceSample& sample = work_.samples[s];
      const std::vector<std::uint32_t> few =
          query.NearestFew(sample.point, kNear, WithinWhich(near_[s], sample));
      near_[s] = Unknown();
      std::copy(few.begin(), few.end(), near_[s].begin());
      const double cost = Dull(ErrorSquared(balls_[few[0]], sample));
      const double without = few.size() > 1 ? Dull(ErrorSquared(balls_[few[1]], sample)) : 1.0;
      loss_[few[0]] += without - cost;
      total += cost;
      ++felt_[few[0]];
      for (const std::uint32_t b : few) ++begin_[b + 1];
    }
    for (std::size_t b = 0; b < balls_.size(); ++b) begin_[b + 1] += begin_[b];
    member_.resize(begin_.back());
    std::vector<std::uint32_t> at(begin_.begin(), begin_.end() - 1);
    for (std::size_t rank = 0; rank < kNear; ++rank) {
      for (std::uint32_t s = 0; s < count; s += stride_) {
        if (near_[s][rank] != kNone) member_[at[near_[s][rank]]++] = s;
      }
    }
    return total / static_cast<double>(looked_at);
  }

  using NearBalls = std::array<std::uint32_t, kNear>;  ///< nearest first; kNone: no more
  static NearBalls Unknown() {
    NearBalls none;
    none.fill(kNone);
    return none;
  }

  /// Returns a bound of the distance of the nearest balls, from the last round's nearest balls.
  double WithinWhich(const NearBalls& last, const SurfaceSample& s) const {
    double within = 0.0;
    for (const std::uint32_t b : last) {
      if (b == kNone) return std::numeric_limits<double>::infinity();
      within = std::max(within, -Offset(balls_[b], s) + 1e-9 * work_.spacing);
    }
    return within;
  }

  /// Moves the least useful balls to where one helps more.
  void Move() {
    std::vector<std::pair<double, std::uint32_t>> spare, needy;
    for (std::uint32_t b = 0; b < balls_.size(); ++b) {
      spare.emplace_back(loss_[b], b);
      needy.emplace_back(-CostWhereFelt(b), b);
    }
    std::sort(spare.begin(), spare.end());
    std::sort(needy.begin(), needy.end());
    const auto most = static_cast<std::size_t>(kMovedShare * static_cast<double>(balls_.size()));
    std::vector<bool> touched(balls_.size(), false);
    std::size_t from = 0;
    for (std::size_t n = 0; n < std::min(most, needy.size()); ++n) {
      const std::uint32_t to = needy[n].second;
      if (touched[to] || felt_[to] < kFewestSamples) continue;
      while (from < spare.size() && touched[spare[from].second]) ++from;
      if (from == spare.size() || !(spare[from].first < -kGainOfSplit * needy[n].first)) break;
      const std::uint32_t moved = spare[from].second;
      if (moved == to) break;
      SurfaceSample foot = work_.samples[WorstOf(to)];
      foot.point -= work_.probe * foot.outward;
      const Sphere ball = work_.inner.Tangent(foot);
      touched[to] = true;
      if (!(ball.radius > 0.0)) continue;
      touched[moved] = true;
      fresh_[moved] = true;
      balls_[moved] = ball;
    }
  }

  std::uint32_t WorstOf(std::uint32_t b) const {
    std::uint32_t worst = FeltAt(b).front();
    double most = -1.0;
    for (const std::uint32_t s : FeltAt(b)) {
      const double error = ErrorSquared(balls_[b], work_.samples[s]);
      if (error > most) {
        most = error;
        worst = s;
      }
    }
    return worst;
  }

  /// Returns the radius that is right on average for a ball at `centre`.
  double RadiusAt(const Vec3& centre, const Sphere& before, std::uint32_t b) const {
    double sum = 0.0, weights = 0.0;
    for (const std::uint32_t k : FeltAt(b)) {
      const SurfaceSample& s = work_.samples[k];
      const double w = DullSlope(ErrorSquared(before, s));
      sum += w * ((s.point - centre).norm() - work_.probe);
      weights += w;
    }
    return std::min(weights > 0.0 ? sum / weights : before.radius, largest_);
  }

  /// Limits the radius so that the ball sticks out nowhere too far.
  double Within(const Vec3& centre, double radius) const {
    const double least = radius - protrusion_;
    return least > 0.0 ? std::min(work_.query.Nearest(centre, least).distance, least) + protrusion_
                       : radius;
  }

  /// Makes one damped Gauss-Newton step of a ball, on the samples at which it is felt.
  void Fit(std::uint32_t b) {
    if (fresh_[b] || felt_[b] < kFewestSamples) return;
    const Sphere ball = balls_[b];
    const Vec3 step = StepOf(ball, b);
    const double cost = Cost(ball, b);
    double share = 1.0;
    // The centre moves less than the ball's radius, and so stays inside the solid.
    const double longest = 0.5 * ball.radius;
    if (step.norm() > longest) share = longest / step.norm();
    // The last trial changes only the radius.
    for (int trial = 0; trial < kTrials; ++trial, share *= trial + 1 < kTrials ? 0.4 : 0.0) {
      Sphere moved{ball.centre + share * step, 0.0};
      moved.radius = RadiusAt(moved.centre, ball, b);
      const auto helps = [&] { return moved.radius > 0.0 && Cost(moved, b) < cost; };
      if (!helps()) continue;  // before the expensive question how much room there is
      const double wanted = moved.radius;
      moved.radius = Within(moved.centre, wanted);
      if (moved.radius < wanted && !helps()) continue;
      balls_[b] = moved;
      return;
    }
  }

  Vec3 StepOf(const Sphere& ball, std::uint32_t b) const {
    Mat4 normal = Mat4::Zero();
    Vec4 right = Vec4::Zero();
    double weights = 0.0;
    for (const std::uint32_t k : FeltAt(b)) {
      const SurfaceSample& s = work_.samples[k];
      const Vec3 d = s.point - ball.centre;
      const double length = d.norm();
      if (!(length > 0.0)) continue;
      const Vec3 u = d / length;
      const double w = DullSlope(ErrorSquared(ball, s));
      Vec4 row;
      row << u / depth_, 1.0 / depth_;
      normal += w * row * row.transpose();
      right -= w * (ball.radius + work_.probe - length) / depth_ * row;
      const Mat3 turn = (Mat3::Identity() - u * u.transpose()) / length;  // -du/dc
      normal.topLeftCorner<3, 3>() += w * turn * turn;
      right.head<3>() += w * turn * (u - s.outward);
      weights += w / (length * length);
    }
    normal += kDamping * weights * Mat4::Identity();
    return Vec3(normal.ldlt().solve(right).head<3>());
  }

  const BallsToBalance& work_;
  std::vector<Sphere>& balls_;
  double depth_, protrusion_, largest_;
  std::uint32_t stride_ = 1;                   ///< of the samples in a round
  std::vector<NearBalls> near_;                ///< for each sample
  std::vector<std::uint32_t> begin_, member_;  ///< samples of each ball, by rank
  std::vector<std::uint32_t> felt_;  ///< for each ball, the number of samples that feel it
  std::vector<double> loss_;         ///< cost if the ball were not there
  std::vector<bool> fresh_;          ///< moved in this round, so its samples are unknown
};

}  // namespace

void BalanceBalls(const BallsToBalance& work, std::vector<Sphere>& balls,
                  const std::function<void(double)>& done) {
  if (balls.empty() || work.samples.empty()) return;
  Balancer(work, balls).Run(done);
}

}  // namespace palpate
