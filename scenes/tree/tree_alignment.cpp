#include "scenes/tree/tree_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "common/error.h"
#include "common/math/elementary.h"
#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/surface_samples.h"

namespace palpate {
namespace {

constexpr std::size_t kSamples = 4000;
constexpr int kSteps = 40;
constexpr double kSettled = 1e-5;                             // of the residual
constexpr double kAsGood = 1.02, kAsGoodWhereItBounds = 2.0;  // of the residual
constexpr double kNothing = 1e-3;                             // of the surface, uncovered
constexpr double kMargin = 0.02;                              // of the mesh's diagonal

struct Box {
  Vec3 low, high;
  Vec3 centre() const { return 0.5 * (low + high); }
  double diagonal() const { return (high - low).norm(); }
};

Box BoxOf(const std::vector<Sphere>& balls) {
  Box box{balls.front().centre, balls.front().centre};
  for (const Sphere& ball : balls) {
    const Vec3 reach = Vec3::Constant(ball.radius);
    box.low = box.low.cwiseMin(ball.centre - reach);
    box.high = box.high.cwiseMax(ball.centre + reach);
  }
  return box;
}

/// The distances of the surface's points to the union of the shifted balls.
struct Fit {
  double residual = 0.0, mean = 0.0, uncovered_share = 0.0;
};

class Aligner {
 public:
  /// @param low, high  bounds of each component of the shift.
  Aligner(const std::vector<SurfaceSample>& samples, const std::vector<Sphere>& balls,
          const Vec3& low, const Vec3& high)
      : samples_(samples), balls_(balls), query_(balls), low_(low), high_(high) {}

  bool Allows(const Vec3& shift) const {
    return (shift.array() >= low_.array()).all() && (shift.array() <= high_.array()).all();
  }

  Fit At(const Vec3& shift) const {
    Fit fit;
    const auto count = static_cast<double>(samples_.size());
    double squares = 0.0;
    for (const SurfaceSample& s : samples_) {
      const double d = query_.Nearest(s.point - shift).distance;
      fit.mean += d / count;
      squares += d * d / count;
      fit.uncovered_share += (d > 0.0) / count;
    }
    fit.residual = std::sqrt(std::max(0.0, squares - fit.mean * fit.mean));
    return fit;
  }

  /// Returns the shift with the least residual near `shift`.
  Vec3 Refine(Vec3 shift) const {
    shift = Allowed(shift);
    Fit fit = At(shift);
    double damping = 1e-3;
    for (int step = 0; step < kSteps && damping < 1e6; ++step) {
      const Vec3 next = Allowed(shift + Step(shift, fit.mean, damping));
      const Fit there = At(next);
      damping *= there.residual < fit.residual ? 0.2 : 10.0;
      if (there.residual >= fit.residual) continue;
      const bool done = fit.residual - there.residual < kSettled * fit.residual;
      shift = next;
      fit = there;
      if (done) break;
    }
    return shift;
  }

 private:
  Vec3 Allowed(const Vec3& shift) const { return shift.cwiseMax(low_).cwiseMin(high_); }

  /// Returns a Gauss-Newton step for shift and mean.  With u the unit vector from a ball's centre
  /// to p - shift, the distance changes with the shift by -u.
  Vec3 Step(const Vec3& shift, double mean, double damping) const {
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (const SurfaceSample& s : samples_) {
      const Vec3 p = s.point - shift;
      const SphereQuery::Hit hit = query_.Nearest(p);
      const Vec3 apart = p - balls_[hit.ball].centre;
      const double length = apart.norm();
      if (!(length > 0.0)) continue;
      Eigen::Vector4d row;
      row << -apart / length, -1.0;
      normal += row * row.transpose();
      right -= row * (hit.distance - mean);
    }
    normal.diagonal() *= 1.0 + damping;
    normal.diagonal().array() += 1e-12 * static_cast<double>(samples_.size());
    return normal.ldlt().solve(right).head<3>();
  }

  const std::vector<SurfaceSample>& samples_;
  const std::vector<Sphere>& balls_;
  SphereQuery query_;
  Vec3 low_, high_;
};

/// Formats a length for people.
std::string Millimetres(double metres) {
  return fmt::format("{:.3g} mm", 1e3 * metres);
}

/// Limits of the ratio of the boxes' diagonals if the unit is right: one ball round a rod is
/// sqrt(3) times as large, and inches taken for cm are off by 2.54.
constexpr double kLargest = 2.5, kSmallest = 0.4;
/// Distances, in spacings, about their mean and about 0, from which on the balls are probably of
/// another mesh; and from which on they certainly are.  With 512 balls over ten shapes, the right
/// balls had at most 0.27 and 0.70 (octree), wrong ones of the same size at least 0.58 or 0.8.
constexpr double kDoubtful = 0.4, kDoubtfulWithMean = 0.8, kApart = 3.0;

void RequireSize(const Box& mesh, const Box& balls) {
  const double ratio = balls.diagonal() / mesh.diagonal();
  if (ratio <= kLargest && ratio >= kSmallest) return;
  throw Error(
      fmt::format("the bounding box of its spheres is {} across, that of the mesh {}, {:.3g} times "
                  "as large; give the \"unit\" of the tree, or the mesh from which it was made",
                  Millimetres(balls.diagonal()), Millimetres(mesh.diagonal()), 1.0 / ratio));
}

/// Writes what is wrong with the fit.
void Judge(bool moved, TreeAlignment& fit) {
  const double all = Length(fit.residual, fit.mean);
  const std::string how = fmt::format(
      "its balls, {} from each other, lie {} +- {} from the surface", Millimetres(fit.spacing),
      Millimetres(std::abs(fit.mean)), Millimetres(fit.residual));
  if (all > kApart * fit.spacing) {
    throw Error(how + (moved ? ", even after alignment; give the mesh from which the tree was made"
                             : "; drop \"align\", and they are aligned with the mesh"));
  }
  if (fit.residual > kDoubtful * fit.spacing || all > kDoubtfulWithMean * fit.spacing) {
    fit.misfit = how + ", as if they were of another mesh or unit: see palpate-scene render";
  }
}

}  // namespace

TreeAlignment AlignBalls(const TriangleMesh& mesh, const std::vector<Sphere>& balls, bool move) {
  const MeshReport report = InspectMesh(mesh);
  const Box box{report.box_min, report.box_max};
  const Box round = BoxOf(balls);
  RequireSize(box, round);
  const MeshQuery query(mesh);
  const std::vector<SurfaceSample> samples = ScatterSamples(mesh, report, query, kSamples);
  // If the balls are of the mesh, one box contains the other, up to a margin.
  const Vec3 match = box.centre() - round.centre();
  const Vec3 slack = 0.5 * ((box.high - box.low) - (round.high - round.low)).cwiseAbs() +
                     Vec3::Constant(kMargin * box.diagonal());
  const Aligner aligner(samples, balls, match - slack, match + slack);

  TreeAlignment found;
  Fit best = aligner.At(found.shift);
  if (move) {
    const std::array<Vec3, 2> likely{Vec3::Zero(), box.centre()};
    for (const Vec3& start : {likely[0], likely[1], match}) {
      const Vec3 shift = aligner.Refine(start);
      const Fit fit = aligner.At(shift);
      if (found.fitted && fit.residual >= best.residual) continue;
      found.shift = shift;
      found.fitted = true;
      best = fit;
    }
    const double least = best.residual;
    for (const Vec3& shift : likely) {
      if (!aligner.Allows(shift)) continue;
      const Fit fit = aligner.At(shift);
      const bool bounds = fit.uncovered_share <= kNothing;
      if (fit.residual > (bounds ? kAsGoodWhereItBounds : kAsGood) * least) continue;
      if (!found.fitted && fit.residual >= best.residual) continue;
      found.shift = shift;
      found.fitted = false;
      best = fit;
    }
  }
  found.residual = best.residual;
  found.mean = best.mean;
  found.uncovered_share = best.uncovered_share;
  found.spacing = std::sqrt(report.area / static_cast<double>(balls.size()));
  Judge(move, found);
  return found;
}

}  // namespace palpate
