#include "scenes/mesh/surface_samples.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <unordered_map>
#include <utility>

namespace palpate {
namespace {

/// splitmix64 (Steele, Lea & Flood, OOPSLA 2014): the same numbers with every standard library.
class Random {
 public:
  double Uniform() {  // [0, 1)
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_ = 0;
};

/// A wall has solid on both sides, by the winding number a little to either side.
bool IsWall(const MeshQuery& query, const SurfaceSample& s, double step) {
  return query.Inside(s.point - step * s.outward) && query.Inside(s.point + step * s.outward);
}

}  // namespace

double PoissonRadius(double area, std::size_t count) {
  return std::sqrt(area / (2.0 * std::sqrt(3.0) * static_cast<double>(count)));
}

std::vector<SurfaceSample> ScatterSamples(const TriangleMesh& mesh, const MeshReport& report,
                                          const MeshQuery& query, std::size_t count) {
  std::vector<double> area_to(mesh.triangles.size());
  double total = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [i, j, k] = mesh.triangles[t];
    const Vec3& a = mesh.vertices[i];
    total += 0.5 * (mesh.vertices[j] - a).cross(mesh.vertices[k] - a).norm();
    area_to[t] = total;
  }
  const bool no_walls = report.solid() && report.components == 1;
  const double step = 0.05 * PoissonRadius(report.area, count);
  Random random;
  std::vector<SurfaceSample> samples;
  std::vector<SurfaceSample> walls;
  std::size_t t = 0;
  for (std::size_t k = 0; k < count; ++k) {
    // One sample in every count-th part of the area: evener than independent ones.
    const double at = (static_cast<double>(k) + random.Uniform()) / static_cast<double>(count);
    while (t + 1 < area_to.size() && area_to[t] <= at * total) ++t;
    const double root = std::sqrt(random.Uniform());
    const double v = root * random.Uniform();
    const auto& [a, b, c] = mesh.triangles[t];
    SurfaceSample s;
    s.triangle = static_cast<std::uint32_t>(t);
    s.point =
        (1.0 - root) * mesh.vertices[a] + (root - v) * mesh.vertices[b] + v * mesh.vertices[c];
    s.outward = query.FaceNormal(s.triangle);
    if (s.outward.isZero()) continue;
    (!no_walls && IsWall(query, s, step) ? walls : samples).push_back(s);
  }
  return samples.empty() ? walls : samples;
}

std::vector<std::uint32_t> ThinOut(const std::vector<SurfaceSample>& samples, std::size_t keep,
                                   double area) {
  const std::size_t count = samples.size();
  const double radius = PoissonRadius(area, keep);
  const double reach = 2.0 * radius;
  // Yuksel's constants: beta 0.65, gamma 1.5, alpha 8.
  const double ratio = static_cast<double>(keep) / static_cast<double>(count);
  const double nearest = 2.0 * radius * (1.0 - ratio * std::sqrt(ratio)) * 0.65;

  // Samples by cells of the size of the reach, sorted; neighbours are in the 27 cells around.
  Vec3 low = samples[0].point;
  for (const SurfaceSample& s : samples) low = low.cwiseMin(s.point);
  const auto cell = [&](const Vec3& p) -> Eigen::Matrix<std::int64_t, 3, 1> {
    return ((p - low) / reach).array().floor().cast<std::int64_t>();
  };
  const auto key = [](std::int64_t x, std::int64_t y, std::int64_t z) {
    return (x + 1) | (y + 1) << 21 | (z + 1) << 42;
  };
  std::vector<std::pair<std::int64_t, std::uint32_t>> by_cell(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto c = cell(samples[i].point);
    by_cell[i] = {key(c.x(), c.y(), c.z()), i};
  }
  std::sort(by_cell.begin(), by_cell.end());
  std::unordered_map<std::int64_t, std::uint32_t> begin;
  begin.reserve(count);
  for (std::uint32_t k = 0; k < count; ++k) begin.try_emplace(by_cell[k].first, k);

  struct Neighbour {
    std::uint32_t sample;
    float weight;
  };
  std::vector<Neighbour> neighbours;
  std::vector<std::uint32_t> neighbours_begin(count + 1, 0);
  std::vector<double> weight(count, 0.0);
  for (std::uint32_t i = 0; i < count; ++i) {
    neighbours_begin[i] = static_cast<std::uint32_t>(neighbours.size());
    const auto c = cell(samples[i].point);
    for (int n = 0; n < 27; ++n) {
      const std::int64_t k = key(c.x() + n % 3 - 1, c.y() + n / 3 % 3 - 1, c.z() + n / 9 - 1);
      const auto it = begin.find(k);
      if (it == begin.end()) continue;
      for (std::uint32_t m = it->second; m < count && by_cell[m].first == k; ++m) {
        const std::uint32_t j = by_cell[m].second;
        if (j == i || !(samples[i].outward.dot(samples[j].outward) > 0.0)) continue;
        const double d = (samples[i].point - samples[j].point).norm();
        if (!(d < reach)) continue;
        double w = 1.0 - std::max(d, nearest) / reach;
        w *= w;
        w *= w;
        w *= w;
        neighbours.push_back({j, static_cast<float>(w)});
        weight[i] += static_cast<float>(w);
      }
    }
  }
  neighbours_begin[count] = static_cast<std::uint32_t>(neighbours.size());

  // Weights only fall, so an entry whose weight has changed is put back where it now belongs.
  std::priority_queue<std::pair<double, std::uint32_t>> crowded;
  for (std::uint32_t i = 0; i < count; ++i) crowded.push({weight[i], i});
  std::vector<bool> removed(count, false);
  for (std::size_t left = count; left > keep;) {
    const auto [w, i] = crowded.top();
    crowded.pop();
    if (w != weight[i]) {
      crowded.push({weight[i], i});
      continue;
    }
    removed[i] = true;
    --left;
    for (std::uint32_t n = neighbours_begin[i]; n < neighbours_begin[i + 1]; ++n) {
      weight[neighbours[n].sample] -= neighbours[n].weight;
    }
  }
  std::vector<std::uint32_t> kept;
  kept.reserve(keep);
  for (std::uint32_t i = 0; i < count; ++i) {
    if (!removed[i]) kept.push_back(i);
  }
  return kept;
}

}  // namespace palpate
