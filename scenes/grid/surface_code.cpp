#include "scenes/grid/surface_code.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace palpate {
namespace {

constexpr double kSteps = 21.0;       // per spacing
constexpr double kStepsBefore = 2.0;  // in spacings
constexpr std::size_t kNarrow = 256;

/// Joins two triangles to a quad.  Returns false if they are not one: they must share their first
/// corner, an edge from it, and their material.
bool Join(const SolidSurface& surface, std::size_t first, std::array<std::uint32_t, 4>& quad) {
  if (first + 1 >= surface.triangles.size()) return false;
  const auto &a = surface.triangles[first], &b = surface.triangles[first + 1];
  if (a[0] != b[0] || surface.materials[first] != surface.materials[first + 1]) return false;
  if (a[2] == b[1]) quad = {a[0], a[1], a[2], b[2]};
  if (a[1] == b[2]) quad = {b[0], b[1], b[2], a[2]};
  return a[2] == b[1] || a[1] == b[2];
}

void Put(std::size_t value, std::vector<std::uint8_t>& code) {
  code.push_back(static_cast<std::uint8_t>(value & 0xff));
  code.push_back(static_cast<std::uint8_t>(value >> 8 & 0xff));
}

}  // namespace

void EncodeSurface(const SolidSurface& surface, const Vec3& begin, double spacing,
                   std::vector<std::uint8_t>& code) {
  std::vector<std::array<std::uint32_t, 4>> quads;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint8_t> materials, of_triangles;
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    std::array<std::uint32_t, 4> quad;
    if (Join(surface, i, quad)) {
      quads.push_back(quad);
      materials.push_back(surface.materials[i++]);
    } else {
      triangles.push_back(surface.triangles[i]);
      of_triangles.push_back(surface.materials[i]);
    }
  }
  materials.insert(materials.end(), of_triangles.begin(), of_triangles.end());

  const std::size_t vertices = materials.empty() ? 0 : surface.vertices.size();
  code.clear();
  for (const std::size_t count : {vertices, quads.size(), triangles.size()}) Put(count, code);
  if (vertices == 0) return;
  for (const Vec3& vertex : surface.vertices) {
    const Vec3 steps = kSteps * ((vertex - begin) / spacing + Vec3::Constant(kStepsBefore));
    for (int k = 0; k < 3; ++k) {
      code.push_back(static_cast<std::uint8_t>(std::clamp(std::round(steps[k]), 0.0, 255.0)));
    }
  }
  const auto put_corners = [&](const auto& face) {
    for (const std::uint32_t index : face) {
      if (vertices <= kNarrow) {
        code.push_back(static_cast<std::uint8_t>(index));
      } else {
        Put(index, code);
      }
    }
  };
  std::ranges::for_each(quads, put_corners);
  std::ranges::for_each(triangles, put_corners);
  const bool same = std::ranges::count(materials, materials[0]) == std::ssize(materials);
  code.insert(code.end(), materials.begin(), same ? materials.begin() + 1 : materials.end());
}

}  // namespace palpate
