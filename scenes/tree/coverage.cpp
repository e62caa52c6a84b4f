#include "scenes/tree/coverage.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/surface_samples.h"
#include "scenes/tree/sphere.h"

namespace palpate {
namespace {

Spread SpreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  return {sum / static_cast<double>(values.size()), values[(values.size() - 1) * 99 / 100],
          values.back()};
}

}  // namespace

Coverage MeasureCoverage(const TriangleMesh& mesh, const SphereTree& tree, std::size_t samples) {
  const MeshReport report = InspectMesh(mesh);
  const MeshQuery query(mesh);
  std::vector<Sphere> balls;
  std::vector<double> outside;
  for (std::size_t i = 0; i < tree.leaves(); ++i) {
    const Sphere ball{{tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]}, tree.leaf_radius[i]};
    const double depth = query.Nearest(ball.centre).distance;
    const bool inside = query.Inside(ball.centre);
    outside.push_back(std::max(0.0, ball.radius + (inside ? -depth : depth)));
    balls.push_back(ball);
  }
  const SphereQuery nearest(std::move(balls));
  std::vector<double> uncovered;
  for (const SurfaceSample& s : ScatterSamples(mesh, report, query, samples)) {
    uncovered.push_back(std::max(0.0, nearest.Nearest(s.point).distance));
  }
  return {SpreadOf(std::move(outside)), SpreadOf(std::move(uncovered))};
}

}  // namespace palpate
