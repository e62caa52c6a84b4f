#include "scenes/grid/surface_code.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace palpate {
namespace {

constexpr double kSteps = 256.0;  // of a spacing
constexpr double kBefore = 4.0;   // spacings
constexpr std::size_t kNarrow = 256;

void Put(std::size_t value, std::vector<std::uint8_t>& code) {
  code.push_back(static_cast<std::uint8_t>(value & 0xff));
  code.push_back(static_cast<std::uint8_t>(value >> 8 & 0xff));
}

}  // namespace

void EncodeSurface(const SolidSurface& surface, const Vec3& begin, double spacing,
                   std::vector<std::uint8_t>& code) {
  code.clear();
  Put(surface.vertices.size(), code);
  Put(surface.triangles.size(), code);
  if (surface.triangles.empty()) return;
  for (const Vec3& vertex : surface.vertices) {
    const Vec3 at = (vertex - begin) / spacing;
    for (int k = 0; k < 3; ++k) {
      const double step = std::round((at[k] + kBefore) * kSteps);
      Put(static_cast<std::size_t>(std::clamp(step, 0.0, 65535.0)), code);
    }
  }
  for (const auto& triangle : surface.triangles) {
    for (const std::uint32_t index : triangle) {
      if (surface.vertices.size() <= kNarrow) {
        code.push_back(static_cast<std::uint8_t>(index));
      } else {
        Put(index, code);
      }
    }
  }
  const bool same = std::ranges::all_of(surface.materials,
                                        [&](std::uint8_t m) { return m == surface.materials[0]; });
  code.insert(code.end(), surface.materials.begin(),
              same ? surface.materials.begin() + 1 : surface.materials.end());
}

}  // namespace palpate
