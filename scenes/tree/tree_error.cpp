#include "scenes/tree/tree_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include "common/math/elementary.h"
#include "scenes/mesh/mesh_solid.h"

namespace palpate {

Distribution DistributionOf(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  Distribution d;
  const auto count = static_cast<double>(values.size());
  for (const double v : values) {
    d.mean += v / count;
    d.rms += v * v / count;
  }
  d.rms = std::sqrt(d.rms);
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * double(values.size() - 1))];
  };
  d.p1 = at(0.01);
  d.p50 = at(0.5);
  d.p99 = at(0.99);
  d.min = values.front();
  d.max = values.back();
  return d;
}

namespace {

struct Exit {
  double height;
  std::uint32_t ball;
};

/// Returns where the line through a point leaves the union along the normal.  Steps by the distance
/// to the nearest ball, which never crosses a boundary, from inside (of the ball that is deepest
/// there) or outside.
std::optional<Exit> FindExit(const SphereQuery& balls, const SurfaceSample& s, double furthest) {
  double height = 0.0;
  SphereQuery::Hit hit = balls.Nearest(s.point);
  const double direction = hit.distance > 0.0 ? -1.0 : 1.0;
  const double enough = 1e-9 * furthest;
  for (int i = 0; i < 10000 && std::abs(hit.distance) > enough; ++i) {
    if ((hit.distance > 0.0) != (direction < 0.0)) break;  // on the boundary, up to rounding
    height += direction * std::abs(hit.distance);
    if (std::abs(height) > furthest) return std::nullopt;
    hit = balls.Nearest(s.point + height * s.outward);
  }
  return Exit{height, hit.ball};
}

std::vector<double> Protrusions(const MeshQuery& query, const std::vector<Sphere>& balls) {
  std::vector<double> protrusion;
  protrusion.reserve(balls.size());
  for (const Sphere& ball : balls) {
    const double distance = query.Nearest(ball.centre).distance;
    const double height = query.Inside(ball.centre) ? -distance : distance;
    protrusion.push_back(std::max(0.0, ball.radius + height));
  }
  return protrusion;
}

/// Returns the volume of the union, by points in its box.
double VolumeOf(const std::vector<Sphere>& balls, const SphereQuery& query, std::size_t samples) {
  Vec3 low = balls.front().centre;
  Vec3 high = low;
  for (const Sphere& ball : balls) {
    low = low.cwiseMin((ball.centre.array() - ball.radius).matrix());
    high = high.cwiseMax((ball.centre.array() + ball.radius).matrix());
  }
  std::mt19937_64 random(20030212);
  const auto uniform = [&] { return double(random() >> 11) * 0x1p-53; };
  std::size_t inside = 0;
  for (std::size_t k = 0; k < samples; ++k) {
    const double x = uniform(), y = uniform(), z = uniform();
    const Vec3 p = low + Vec3(x, y, z).cwiseProduct(high - low);
    inside += query.Nearest(p).distance < 0.0;
  }
  return (high - low).prod() * double(inside) / double(samples);
}

}  // namespace

std::vector<double> OffsetsAt(const std::vector<SurfaceSample>& points, const SphereQuery& balls,
                              double furthest) {
  std::vector<double> offsets;
  offsets.reserve(points.size());
  for (const SurfaceSample& s : points) {
    const std::optional<Exit> exit = FindExit(balls, s, furthest);
    offsets.push_back(exit ? exit->height : std::numeric_limits<double>::quiet_NaN());
  }
  return offsets;
}

SurfaceGauge::SurfaceGauge(const TriangleMesh& solid, std::size_t samples)
    : samples_(samples),
      report_(InspectMesh(solid)),
      query_(solid),
      points_(ScatterSamples(solid, report_, query_, samples)) {}

UnionError SurfaceGauge::Measure(const std::vector<Sphere>& balls, Figures figures) const {
  UnionError error;
  error.spheres = balls.size();
  if (balls.empty()) return error;
  const SphereQuery nearest(balls);
  std::vector<double> offset, tilt, bareness, off;
  std::size_t uncovered = 0, missed = 0;
  for (const SurfaceSample& s : points_) {
    bareness.push_back(std::max(0.0, nearest.Nearest(s.point).distance));
    uncovered += bareness.back() > 0.0;
    const std::optional<Exit> exit = FindExit(nearest, s, diagonal());
    off.push_back(exit ? std::abs(exit->height) : bareness.back());
    if (!exit) {
      ++missed;
      error.mean_lean += M_PI / 2.0;
      continue;
    }
    offset.push_back(exit->height);
    const Vec3 normal = s.point + exit->height * s.outward - balls[exit->ball].centre;
    tilt.push_back(Atan2(normal.cross(s.outward).norm(), normal.dot(s.outward)));
    error.mean_lean += tilt.back();
  }
  const auto count = static_cast<double>(std::max<std::size_t>(points_.size(), 1));
  error.uncovered_share = double(uncovered) / count;
  error.missed_share = double(missed) / count;
  error.mean_lean /= count;
  if (!off.empty()) {
    const auto at = off.begin() + std::ptrdiff_t(0.95 * double(off.size() - 1));
    std::nth_element(off.begin(), at, off.end());
    error.off_p95 = *at;
  }
  error.offset = DistributionOf(std::move(offset));
  error.tilt = DistributionOf(std::move(tilt));
  error.bareness = DistributionOf(std::move(bareness));
  if (figures == Figures::kSurface) return error;
  error.protrusion = DistributionOf(Protrusions(query_, balls));
  if (report_.solid() && report_.volume > 0.0) {
    error.volume_ratio = VolumeOf(balls, nearest, samples_) / report_.volume;
  }
  return error;
}

std::vector<std::vector<Sphere>> BallsByLevel(const SphereTree& tree) {
  std::vector<std::vector<Sphere>> levels;
  for (int l = 0; l < tree.levels(); ++l) {
    std::vector<Sphere>& balls = levels.emplace_back();
    if (l + 1 == tree.levels()) {
      for (std::size_t i = 0; i < tree.leaves(); ++i) {
        balls.push_back({{tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]}, tree.leaf_radius[i]});
      }
      break;
    }
    for (const SpherePacket& packet : tree.level(l)) {
      for (int lane = 0; lane < kTreeArity; ++lane) {
        if (packet.child[lane] < 0) continue;
        balls.push_back({{packet.x[lane], packet.y[lane], packet.z[lane]}, packet.radius[lane]});
      }
    }
  }
  return levels;
}

std::vector<UnionError> MeasureLevels(const TriangleMesh& mesh, const SphereTree& tree,
                                      std::size_t samples) {
  const MeshSolid solid = SolidOf(mesh);
  const SurfaceGauge gauge(solid.mesh, samples);
  std::vector<UnionError> levels;
  for (const std::vector<Sphere>& balls : BallsByLevel(tree)) {
    levels.push_back(gauge.Measure(balls));
  }
  return levels;
}

Coverage MeasureCoverage(const TriangleMesh& mesh, const SphereTree& tree, std::size_t samples) {
  const MeshQuery query(mesh);
  const std::vector<Sphere> balls = BallsByLevel(tree).back();
  const SphereQuery nearest(balls);
  std::vector<double> uncovered;
  for (const SurfaceSample& s : ScatterSamples(mesh, InspectMesh(mesh), query, samples)) {
    uncovered.push_back(std::max(0.0, nearest.Nearest(s.point).distance));
  }
  return {DistributionOf(Protrusions(query, balls)), DistributionOf(std::move(uncovered))};
}

}  // namespace palpate
