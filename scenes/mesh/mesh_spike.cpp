#include "scenes/mesh/mesh_spike.h"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "scenes/mesh/figure.h"

namespace palpate {
namespace {

constexpr double kShorter = 2.0 / 3.0;
constexpr double kOfMedianNeighbour = 10.0;

/// Returns the longest side of the box of all used vertices but one.
double LongestWithout(const TriangleMesh& mesh, const std::vector<bool>& used, std::uint32_t v) {
  Eigen::AlignedBox3d box;
  for (std::uint32_t w = 0; w < mesh.vertices.size(); ++w) {
    if (used[w] && w != v) box.extend(mesh.vertices[w]);
  }
  return box.isEmpty() ? 0.0 : box.sizes().maxCoeff();
}

}  // namespace

std::optional<Spike> FindSpike(const TriangleMesh& mesh) {
  std::vector<bool> used(mesh.vertices.size(), false);
  std::vector<double> lengths;
  lengths.reserve(3 * mesh.triangles.size());
  std::vector<double> shortest(mesh.vertices.size(), std::numeric_limits<double>::infinity());
  Eigen::AlignedBox3d box;
  for (const auto& t : mesh.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = t[c], b = t[(c + 1) % 3];
      used[a] = true;
      box.extend(mesh.vertices[a]);
      if (a == b) continue;
      lengths.push_back((mesh.vertices[b] - mesh.vertices[a]).norm());
      shortest[a] = std::min(shortest[a], lengths.back());
      shortest[b] = std::min(shortest[b], lengths.back());
    }
  }
  if (lengths.empty()) return std::nullopt;
  const auto median = lengths.begin() + std::ssize(lengths) / 2;
  std::nth_element(lengths.begin(), median, lengths.end());
  // A vertex that enlarges the box lies on one of its six sides.
  std::array<std::uint32_t, 6> on_sides;
  on_sides.fill(0);
  std::array<bool, 6> found{};
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!used[v]) continue;
    for (int axis = 0; axis < 3; ++axis) {
      for (int side = 0; side < 2; ++side) {
        const double end = side == 0 ? box.min()[axis] : box.max()[axis];
        const auto n = static_cast<std::size_t>(2 * axis + side);
        if (mesh.vertices[v][axis] != end || found[n]) continue;
        found[n] = true;
        on_sides[n] = v;
      }
    }
  }
  std::optional<Spike> spike;
  for (const std::uint32_t v : on_sides) {
    if (!(shortest[v] > kOfMedianNeighbour * *median)) continue;
    const double without = LongestWithout(mesh, used, v);
    if (!(without < kShorter * box.sizes().maxCoeff())) continue;
    if (spike && spike->without <= without) continue;
    spike = Spike{mesh.vertices[v], box.sizes().maxCoeff(), without};
  }
  return spike;
}

std::string SpikeRemark(const Spike& spike) {
  return "a vertex is far from all others, at (" + Figure(spike.at.x(), 6) + ", " +
         Figure(spike.at.y(), 6) + ", " + Figure(spike.at.z(), 6) +
         ") of the file's unit: without it the longest side is " + Figure(spike.without, 3) +
         " in place of " + Figure(spike.longest, 3) + "; delete it in a mesh editor" +
         (spike.certain() ? "" : ", if it is no tip that should be there");
}

}  // namespace palpate
