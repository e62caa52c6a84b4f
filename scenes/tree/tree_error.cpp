#include "scenes/tree/tree_error.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/mesh_solid.h"
#include "scenes/mesh/surface_samples.h"

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

/// Where the line through a point leaves the union along the normal.  The distance to the nearest
/// ball never steps over a boundary, from within (of the ball that is deepest there) as from
/// outside.
std::optional<Exit> FindExit(const SphereQuery& balls, const SurfaceSample& s, double furthest) {
  double height = 0.0;
  SphereQuery::Hit hit = balls.Nearest(s.point);
  const double direction = hit.distance > 0.0 ? -1.0 : 1.0;
  const double enough = 1e-9 * furthest;
  for (int i = 0; i < 10000 && std::abs(hit.distance) > enough; ++i) {
    if ((hit.distance > 0.0) != (direction < 0.0)) break;  // to rounding, on the boundary
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

/// Volume of the union, by points in its box.
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

UnionError MeasureUnion(const TriangleMesh& mesh, const std::vector<Sphere>& balls,
                        std::size_t samples) {
  UnionError error;
  error.spheres = balls.size();
  if (balls.empty()) return error;
  const MeshReport report = InspectMesh(mesh);
  const MeshQuery query(mesh);
  const SphereQuery nearest(balls);
  const double furthest = (report.box_max - report.box_min).norm();
  std::vector<double> offset, tilt, bareness;
  std::size_t uncovered = 0, missed = 0;
  const std::vector<SurfaceSample> points = ScatterSamples(mesh, report, query, samples);
  for (const SurfaceSample& s : points) {
    bareness.push_back(std::max(0.0, nearest.Nearest(s.point).distance));
    uncovered += bareness.back() > 0.0;
    const std::optional<Exit> exit = FindExit(nearest, s, furthest);
    if (!exit) {
      ++missed;
      continue;
    }
    offset.push_back(exit->height);
    const Vec3 normal = s.point + exit->height * s.outward - balls[exit->ball].centre;
    tilt.push_back(std::atan2(normal.cross(s.outward).norm(), normal.dot(s.outward)));
  }
  const auto count = static_cast<double>(std::max<std::size_t>(points.size(), 1));
  error.uncovered_share = double(uncovered) / count;
  error.missed_share = double(missed) / count;
  error.offset = DistributionOf(std::move(offset));
  error.tilt = DistributionOf(std::move(tilt));
  error.bareness = DistributionOf(std::move(bareness));
  error.protrusion = DistributionOf(Protrusions(query, balls));
  if (report.solid() && report.volume > 0.0) {
    error.volume_ratio = VolumeOf(balls, nearest, samples) / report.volume;
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
  std::vector<UnionError> levels;
  for (const std::vector<Sphere>& balls : BallsByLevel(tree)) {
    levels.push_back(MeasureUnion(solid.mesh, balls, samples));
  }
  return levels;
}

}  // namespace palpate
