#include "tests/support/folded_plates.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "tests/support/dirty_mesh.h"
#include "tests/support/flat_plates.h"

namespace palpate::test {
namespace {

/// Adds a plate that a map bends to a side of a body, without those walls that lie within it.
/// @param turned  whether the map is a mirror.
/// @param inner  says of a corner of the plate whether it is at a wall to leave out, 1 or 2, or
/// not.
template <class Map, class Inner>
void AddSide(TriangleMesh& body, const TriangleMesh& plate, bool turned, Map map, Inner inner) {
  TriangleMesh side;
  for (const auto& [a, b, c] : plate.triangles) {
    const int wall = inner(plate.vertices[a]);
    if (wall != 0 && wall == inner(plate.vertices[b]) && wall == inner(plate.vertices[c])) continue;
    side.triangles.push_back(turned ? std::array{a, c, b} : std::array{a, b, c});
  }
  for (const Vec3& v : plate.vertices) side.vertices.push_back(map(v));
  body = Both(std::move(body), side);
}

}  // namespace

TriangleMesh MakeGroove(std::string_view tessellation, double half_angle, std::uint64_t right,
                        std::uint64_t left) {
  const double sine = std::sin(half_angle), cosine = std::cos(half_angle);
  TriangleMesh groove;
  for (const double side : {1.0, -1.0}) {
    AddSide(
        groove, MakePlate(tessellation, side > 0.0 ? right : left), side < 0.0,
        [&](const Vec3& v) {
          const double up = v.x() + kPlateHalf;
          return Vec3(side * up * sine, up * cosine + v.y(), v.z());
        },
        [](const Vec3& v) { return v.x() == -kPlateHalf ? 1 : 0; });
  }
  return groove;
}

TriangleMesh MakeHole(std::string_view tessellation, std::span<const Vec3> outline,
                      std::uint64_t seed) {
  const TriangleMesh plate = MakePlate(tessellation, seed);
  TriangleMesh hole;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec3 &a = outline[i], &b = outline[(i + 1) % outline.size()];
    AddSide(
        hole, plate, true,
        [&](const Vec3& v) {
          // Exact at both ends, so that sides meet.
          const double to_b = (v.z() + kPlateHalf) / (2.0 * kPlateHalf);
          const double out = v.y() == 0.0 ? 1.0 : 1.5;
          const Vec3 at = out * ((1.0 - to_b) * a + to_b * b);
          return Vec3(at.x(), at.y(), v.x());
        },
        [](const Vec3& v) { return v.z() == -kPlateHalf  ? 1
                                   : v.z() == kPlateHalf ? 2
                                                         : 0; });
  }
  return hole;
}

}  // namespace palpate::test
