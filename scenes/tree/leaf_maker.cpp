#include "scenes/tree/leaf_maker.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <queue>
#include <utility>

#include "common/error.h"
#include "scenes/tree/balanced_balls.h"
#include "scenes/tree/inner_balls.h"

namespace palpate {
namespace {

constexpr std::size_t kCandidatesPerLeaf = 5;  // Yuksel's advice
constexpr std::size_t kFewestCandidates = 2000;
constexpr double kEvenShare = 0.8;    // of the leaves: they touch at evenly spread points
constexpr double kInsideShare = 0.1;  // at most
constexpr std::size_t kSamplesPerBalancedLeaf = 24;
constexpr double kLargestBalanced = 10.0;  // spacings
constexpr double kProbe = 0.5;  // radius of the probe for balanced leaves, of the spacing

/// Surface samples, and the distance of each to the nearest ball, updated as balls are added.
class Bareness {
 public:
  Bareness(const std::vector<SurfaceSample>& samples, const std::vector<Sphere>& leaves)
      : samples_(samples), distance_(samples.size()) {
    const SphereQuery query(leaves);
    // A box tree over the samples is not needed: they are sorted along one axis, and a ball
    // reaches only few.
    for (std::uint32_t i = 0; i < samples.size(); ++i) {
      distance_[i] = query.Nearest(samples[i].point).distance;
      largest_ = std::max(largest_, distance_[i]);
      along_.push_back({samples[i].point.x(), i});
    }
    std::sort(along_.begin(), along_.end());
  }

  double operator[](std::uint32_t sample) const { return distance_[sample]; }

  void Add(const Sphere& ball) {
    const double reach = ball.radius + largest_;
    auto it = std::lower_bound(along_.begin(), along_.end(),
                               std::pair<double, std::uint32_t>(ball.centre.x() - reach, 0u));
    for (; it != along_.end() && it->first <= ball.centre.x() + reach; ++it) {
      const double d = (samples_[it->second].point - ball.centre).norm() - ball.radius;
      distance_[it->second] = std::min(distance_[it->second], d);
    }
  }

 private:
  const std::vector<SurfaceSample>& samples_;
  std::vector<double> distance_;
  double largest_ = 0.0;
  std::vector<std::pair<double, std::uint32_t>> along_;
};

/// Adds `count` tangent balls where the surface is furthest from all others.
void CoverBarest(const std::vector<SurfaceSample>& samples, const InnerBalls& inner, double spacing,
                 std::size_t count, std::vector<Sphere>& leaves) {
  Bareness bare(samples, leaves);
  std::priority_queue<std::pair<double, std::uint32_t>> worst;
  std::vector<std::optional<Sphere>> known;
  const auto begin = [&] {
    for (std::uint32_t i = 0; i < samples.size(); ++i) worst.push({bare[i], i});
    known.assign(samples.size(), {});
  };
  begin();
  bool is_thin = false;
  while (count > 0) {
    if (worst.empty()) {
      if (std::exchange(is_thin, true)) {
        throw Error(
            "the mesh encloses no volume to put spheres into: its faces are back to back, or a "
            "vertex is far away; give \"thickness_mm\" in the scene file, or remove the vertex");
      }
      begin();  // a shell, of walls thinner than the balls that would cover it well
    }
    const auto [score, i] = worst.top();
    worst.pop();
    if (!known[i]) known[i] = is_thin ? inner.Within(samples[i]) : inner.Tangent(samples[i]);
    if (!(known[i]->radius > 0.0)) continue;  // no ball fits there
    // A ball in a sharp edge is as small as its distance from the edge, and covers little.
    const double now = bare[i] * std::min(1.0, known[i]->radius / spacing);
    if (now < score && !(worst.empty() || now >= worst.top().first)) {
      worst.push({now, i});
      continue;
    }
    leaves.push_back(*known[i]);
    bare.Add(*known[i]);
    worst.push({0.0, i});  // last resort, if all samples are taken
    --count;
  }
}

MeshReport RequireRenderable(const TriangleMesh& mesh) {
  MeshReport report = InspectMesh(mesh);
  if (!report.refusal.empty()) throw Error(report.refusal);
  return report;
}

/// Makes the leaves in each mode that begins with balls that touch the surface from inside.
class BallFitter {
 public:
  BallFitter(const SampledSolid& solid, std::size_t count, TreeMode mode, const Progress& progress)
      : solid_(solid),
        count_(count),
        mode_(mode),
        progress_(progress),
        even_(static_cast<std::size_t>(kEvenShare * static_cast<double>(count))),
        spacing_(2.0 * PoissonRadius(solid.report.area, std::max<std::size_t>(even_, 1))),
        inner_(solid.report, solid.query, spacing_,
               mode == TreeMode::kInside ? InnerBalls::kLargestTouching : kLargestBalanced) {}

  std::vector<Sphere> Make() const {
    std::vector<Sphere> leaves = Touching();
    const std::vector<Sphere> fill = Fill(leaves);
    if (mode_ == TreeMode::kInside) leaves.insert(leaves.end(), fill.begin(), fill.end());
    Tell("covering the largest gaps", 0.6);
    const std::size_t kept = mode_ == TreeMode::kInside ? 0 : fill.size();
    CoverBarest(solid_.samples, inner_, spacing_, count_ - leaves.size() - kept, leaves);
    if (mode_ == TreeMode::kInside) return leaves;
    const auto done = [&](double share) { Tell(NameOf(mode_), 0.6 + 0.2 * share); };
    const double probe = kProbe * spacing_;
    const std::vector<SurfaceSample> dense =
        ScatterAbove(solid_.mesh, solid_.report, solid_.query, probe,
                     std::max(kSamplesPerBalancedLeaf * count_, kFewestCandidates));
    BalanceBalls({solid_.query, inner_, dense, probe, spacing_}, leaves, done);
    leaves.insert(leaves.end(), fill.begin(), fill.end());
    return leaves;
  }

 private:
  void Tell(std::string_view stage, double fraction) const {
    if (progress_) progress_(stage, fraction);
  }

  /// Returns balls for the space inside that those at the surface leave.
  std::vector<Sphere> Fill(const std::vector<Sphere>& leaves) const {
    Tell("filling the inside", 0.5);
    const auto most = static_cast<std::size_t>(std::ceil(kInsideShare * double(count_)));
    return inner_.Fill(leaves, std::min(most, count_ - leaves.size()));
  }

  /// Returns balls that touch the surface at evenly spread points.
  std::vector<Sphere> Touching() const {
    Tell("fitting balls", 0.1);
    std::vector<Sphere> leaves;
    if (even_ == 0) return leaves;
    for (std::uint32_t i : ThinOut(solid_.samples, even_, solid_.report.area)) {
      const Sphere ball = inner_.Tangent(solid_.samples[i]);
      if (ball.radius > 0.0) leaves.push_back(ball);
      if (leaves.size() % 256 == 0) {
        Tell("fitting balls", 0.1 + 0.4 * double(leaves.size()) / double(even_));
      }
    }
    return leaves;
  }

  const SampledSolid& solid_;
  std::size_t count_;
  TreeMode mode_;
  const Progress& progress_;
  std::size_t even_;
  double spacing_;
  InnerBalls inner_;
};

}  // namespace

SampledSolid::SampledSolid(const TriangleMesh& solid, std::size_t leaves)
    : mesh(solid),
      report(RequireRenderable(solid)),
      query(solid),
      samples(ScatterSamples(solid, report, query,
                             std::max(kCandidatesPerLeaf * leaves, kFewestCandidates))) {}

std::vector<Sphere> MakeLeaves(const SampledSolid& solid, std::size_t count, TreeMode mode,
                               const Progress& progress) {
  switch (mode) {
    case TreeMode::kInside:
    case TreeMode::kBalanced:
      return BallFitter(solid, count, mode, progress).Make();
  }
  throw Error("there is no such mode of a tree");  // an invalid number cast to TreeMode
}

}  // namespace palpate
