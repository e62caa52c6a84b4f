#include "scenes/tree/cover_balls.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "common/math/elementary.h"

namespace palpate {
namespace {

constexpr double kBitSize = 0.3;  // of the spacing: the longest edge of a bit
constexpr int kRounds = 40;
constexpr int kWholeRounds = 4;            // the last rounds, which use all bits
constexpr std::size_t kBitsForABall = 60;  // in the other rounds
constexpr double kMovedShare = 0.04;       // of the balls, each round
constexpr std::size_t kNear = 6;           // balls considered for each bit
constexpr int kSteps = 8;                  // steps of a centre in each round
constexpr double kFirstStep = 0.1;         // of the radius
// factors of the step, after one that helped or did not
constexpr double kLonger = 1.3, kShorter = 0.4;
constexpr double kSoft =
    0.002;  // of the radius: corners nearly as far as the farthest count as well
constexpr double kNegligible = 10.0;
/// Extension of a ball beyond its bits, as a share of its radius: a corner on its boundary is then
/// inside in other computations, too.
constexpr double kMargin = 1e-9;
constexpr std::uint32_t kNone = 0xffffffffu;

/// A triangle, or part of one.
struct Bit {
  Vec3 corner[3];
  std::uint32_t triangle;

  Vec3 Middle() const { return (corner[0] + corner[1] + corner[2]) / 3.0; }
  double Farthest(const Vec3& from) const {
    double most = 0.0;
    for (const Vec3& x : corner) most = std::max(most, (x - from).squaredNorm());
    return std::sqrt(most);
  }
};

/// Returns the most bits that a mesh is cut into.  A mesh without needles has some 40 per ball; a
/// needle a thousand times as long as the balls' spacing would have millions.
std::size_t MostBits(const TriangleMesh& mesh, std::size_t balls) {
  return (std::size_t{1} << 19) + 2 * mesh.triangles.size() + 100 * balls;
}

/// Cuts triangles in halves across their longest edges until none is longer than `longest`; returns
/// nothing if there would be more than `most`.
std::optional<std::vector<Bit>> CutUp(const TriangleMesh& mesh, double longest, std::size_t most) {
  std::vector<Bit> bits, left;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [i, j, k] = mesh.triangles[t];
    left.push_back({{mesh.vertices[i], mesh.vertices[j], mesh.vertices[k]}, t});
    while (!left.empty()) {
      const Bit bit = left.back();
      left.pop_back();
      int edge = 0;
      double length_of_edge = 0.0;
      for (int e = 0; e < 3; ++e) {
        const double length = (bit.corner[(e + 1) % 3] - bit.corner[e]).norm();
        if (length > length_of_edge) edge = e;
        length_of_edge = std::max(length_of_edge, length);
      }
      if (!(length_of_edge > longest)) {
        if (bits.size() == most) return std::nullopt;
        bits.push_back(bit);
        continue;
      }
      const Vec3 &a = bit.corner[edge], &b = bit.corner[(edge + 1) % 3],
                 &c = bit.corner[(edge + 2) % 3];
      const Vec3 middle = 0.5 * (a + b);
      left.push_back({{a, middle, c}, t});
      left.push_back({{middle, b, c}, t});
    }
  }
  return bits;
}

/// Returns bits as small as needed, or as their number allows: larger bits need larger balls.
std::vector<Bit> BitsOfMesh(const TriangleMesh& mesh, double longest, std::size_t balls) {
  for (;; longest *= 2.0) {
    if (auto bits = CutUp(mesh, longest, MostBits(mesh, balls))) return *std::move(bits);
  }
}

class Coverer {
 public:
  Coverer(const SurfaceToCover& work, std::vector<Sphere>& balls)
      : work_(work),
        balls_(balls),
        bits_(BitsOfMesh(work.mesh, kBitSize * work.spacing, balls.size())) {}

  void Run(const std::function<void(double)>& done) {
    for (Sphere& ball : balls_) ball.radius = PlaceOf(ball.centre).room;
    std::vector<Sphere> best;
    double best_cost = std::numeric_limits<double>::infinity();
    for (int round = 0; round <= kRounds; ++round) {
      const bool whole = round > kRounds - kWholeRounds;
      if (whole && stride_ > 1) best_cost = std::numeric_limits<double>::infinity();
      stride_ = whole ? 1 : Sparse();
      const double cost = Assign();
      if (cost < best_cost) {
        best_cost = cost;
        best = balls_;
      }
      if (round == kRounds) break;
      fresh_.assign(balls_.size(), false);
      if (round % 2 == 0) Move();
      for (std::uint32_t b = 0; b < balls_.size(); ++b) Fit(b);
      done(double(round + 1) / kRounds);
    }
    balls_ = std::move(best);
    Assign();  // with all bits
    for (std::uint32_t b = 0; b < balls_.size(); ++b) {
      Sphere& ball = balls_[b];
      ball.radius = std::max(ball.radius, Reach(ball.centre, b)) * (1.0 + kMargin);
    }
  }

 private:
  /// The place of a ball's centre.
  struct Place {
    Vec3 centre, nearest;  ///< `nearest`: the nearest point of the surface
    double room;           ///< radius of the largest ball that does not stick out; negative outside
  };
  Place PlaceOf(const Vec3& centre) const { return PlaceOf(centre, work_.query.Inside(centre)); }
  Place PlaceOf(const Vec3& centre, bool inside) const {
    const MeshQuery::Hit hit = work_.query.Nearest(centre);
    return {centre, hit.point, inside ? hit.distance : -hit.distance};
  }
  /// Returns the place after a step.  A step shorter than the distance to the surface does
  /// not cross it.
  Place After(const Place& at, const Vec3& step) const {
    const Vec3 centre = at.centre + step;
    return at.room > step.norm() ? PlaceOf(centre, true) : PlaceOf(centre);
  }

  std::uint32_t BitOf(std::uint32_t i) const { return static_cast<std::uint32_t>(i * stride_); }
  std::span<const std::uint32_t> BitsOf(std::uint32_t b) const {
    return {member_.data() + begin_[b], member_.data() + begin_[b + 1]};
  }

  /// Returns the radius of the ball about a point that contains the bits of ball b.
  double Reach(const Vec3& centre, std::uint32_t b) const {
    double reach = 0.0;
    for (const std::uint32_t k : BitsOf(b)) reach = std::max(reach, bits_[k].Farthest(centre));
    return reach;
  }

  /// Returns the stride with which few enough bits remain to place the balls.
  std::size_t Sparse() const {
    return std::max<std::size_t>(bits_.size() / (kBitsForABall * balls_.size()), 1);
  }

  /// Assigns each bit to the ball that sticks out least for it.  Finds how much each ball sticks
  /// out, for which bit, and how much others would in its place.
  /// @returns the cost: the mean square of how far they stick out.
  double Assign() {
    const SphereQuery query(balls_);
    const std::size_t balls = balls_.size();
    owner_.resize((bits_.size() + stride_ - 1) / stride_);
    sticks_out_.assign(balls, 0.0);
    without_.assign(balls, 0.0);
    worst_.assign(balls, kNone);
    begin_.assign(balls + 1, 0);
    for (std::uint32_t i = 0; i < owner_.size(); ++i) {
      const std::uint32_t k = BitOf(i);
      double least = std::numeric_limits<double>::infinity(), second = least;
      std::uint32_t owner = kNone;
      for (const std::uint32_t b : query.NearestFew(bits_[k].Middle(), kNear)) {
        const double out = bits_[k].Farthest(balls_[b].centre) - balls_[b].radius;
        if (out < least) {
          second = least;
          least = out;
          owner = b;
        } else {
          second = std::min(second, out);
        }
      }
      owner_[i] = owner;
      ++begin_[owner + 1];
      without_[owner] = std::max(without_[owner], second);
      if (worst_[owner] == kNone || least > sticks_out_[owner]) worst_[owner] = k;
      sticks_out_[owner] = std::max(sticks_out_[owner], least);
    }
    for (std::size_t b = 0; b < balls; ++b) begin_[b + 1] += begin_[b];
    member_.resize(owner_.size());
    std::vector<std::uint32_t> at(begin_.begin(), begin_.end() - 1);
    for (std::uint32_t i = 0; i < owner_.size(); ++i) member_[at[owner_[i]]++] = BitOf(i);
    double cost = 0.0;
    for (const double out : sticks_out_) cost += out * out;
    return cost / static_cast<double>(balls);
  }

  /// Moves balls that others can replace to where a ball sticks out more than those
  /// others then would.
  void Move() {
    std::vector<std::pair<double, std::uint32_t>> spare, needy;
    for (std::uint32_t b = 0; b < balls_.size(); ++b) {
      spare.emplace_back(without_[b], b);
      needy.emplace_back(-sticks_out_[b], b);
    }
    std::sort(spare.begin(), spare.end());
    std::sort(needy.begin(), needy.end());
    const auto most =
        static_cast<std::size_t>(std::max(1.0, kMovedShare * static_cast<double>(balls_.size())));
    std::size_t from = 0;
    for (std::size_t n = 0; n < std::min(most, needy.size()); ++n) {
      const auto [out, to] = needy[n];
      while (from < spare.size() && fresh_[spare[from].second]) ++from;
      if (from == spare.size() || !(spare[from].first < -out)) break;
      const std::uint32_t moved = spare[from].second;
      if (moved == to || fresh_[to] || worst_[to] == kNone) continue;
      const Bit& bit = bits_[worst_[to]];
      const Sphere ball =
          work_.inner.Tangent({bit.Middle(), work_.query.FaceNormal(bit.triangle), bit.triangle});
      if (!(ball.radius > 0.0)) continue;
      fresh_[moved] = fresh_[to] = true;
      balls_[moved] = ball;
      ++from;
    }
  }

  /// Moves a ball's centre to where it sticks out less for its bits.
  void Fit(std::uint32_t b) {
    if (fresh_[b] || BitsOf(b).empty()) return;
    Place at = PlaceOf(balls_[b].centre, balls_[b].radius > 0.0);
    double reach = Reach(at.centre, b);
    double length = kFirstStep * reach;
    for (int i = 0; i < kSteps; ++i) {
      const Vec3 way = Downhill(at, reach, b);
      if (!(way.squaredNorm() > 0.0)) break;
      const Place next = After(at, length * way.normalized());
      const double next_reach = Reach(next.centre, b);
      const bool better = next_reach - next.room < reach - at.room;
      length *= better ? kLonger : kShorter;
      if (!better) continue;
      at = next;
      reach = next_reach;
    }
    balls_[b] = {at.centre, at.room};
  }

  /// Returns the direction against the gradient of max |x - c| - d(c): to the farthest corners,
  /// with soft weights, and away from the nearest point of the surface.
  Vec3 Downhill(const Place& at, double reach, std::uint32_t b) const {
    Vec3 far = Vec3::Zero();
    double weights = 0.0;
    for (const std::uint32_t k : BitsOf(b)) {
      for (const Vec3& x : bits_[k].corner) {
        const Vec3 to = x - at.centre;
        const double length = to.norm();
        const double less = (reach - length) / (kSoft * reach);
        if (less > kNegligible) continue;
        const double weight = Exp(-less);
        far += weight / length * to;
        weights += weight;
      }
    }
    Vec3 out = at.room > 0.0 ? Vec3(at.nearest - at.centre) : Vec3(at.centre - at.nearest);
    if (out.squaredNorm() > 0.0) out.normalize();
    return far / weights - out;
  }

  const SurfaceToCover& work_;
  std::vector<Sphere>& balls_;  ///< during the work with radius d(c), negative outside
  std::vector<Bit> bits_;
  std::size_t stride_ = 1;                     ///< of the bits in a round
  std::vector<std::uint32_t> owner_;           ///< for each of them, its ball
  std::vector<std::uint32_t> begin_, member_;  ///< bits of each ball
  std::vector<double> sticks_out_;             ///< for each ball [m]
  std::vector<double> without_;                ///< how much others would, if it were not there [m]
  std::vector<std::uint32_t> worst_;           ///< the bit for which it sticks out most
  std::vector<bool> fresh_;                    ///< moved in this round, so its bits are unknown
};

}  // namespace

void CoverWithBalls(const SurfaceToCover& work, std::vector<Sphere>& balls,
                    const std::function<void(double)>& done) {
  if (!balls.empty()) Coverer(work, balls).Run(done);
}

}  // namespace palpate
