#include "tests/support/plain_tools.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "common/error.h"
#include "scenes/shapes/shapes.h"
#include "tests/support/dirty_mesh.h"
#include "tests/support/random.h"
#include "tests/support/sharp_bodies.h"
#include "tests/support/test_scenes.h"

namespace palpate::test {
namespace {

std::vector<Vec3> Polygon(int corners, double radius) {
  std::vector<Vec3> outline;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * M_PI * i / corners;
    outline.push_back({radius * std::cos(angle), radius * std::sin(angle), 0.0});
  }
  return outline;
}

/// Puts the axis of what was extruded along z upright.
TriangleMesh Upright(TriangleMesh mesh) {
  for (Vec3& v : mesh.vertices) v = Vec3(v.y(), v.z(), v.x());
  return mesh;
}

TriangleMesh Prism(int corners, double radius, double height) {
  return Upright(Extruded(Polygon(corners, radius), height));
}

/// A cup upside down: rings of the outer foot, inner foot, ceiling and top, and two lids.
TriangleMesh Cup(double outer, double inner, double ceiling, double height) {
  constexpr std::uint32_t kCorners = 48, kRings = 4;
  const double radius[kRings] = {outer, inner, inner, outer}, y[kRings] = {0, 0, ceiling, height};
  TriangleMesh cup;
  for (std::uint32_t ring = 0; ring < kRings; ++ring) {
    for (const Vec3& v : Polygon(kCorners, radius[ring])) {
      cup.vertices.push_back({v.x(), y[ring], v.y()});
    }
  }
  for (const double lid : {ceiling, height}) cup.vertices.push_back({0.0, lid, 0.0});
  const std::uint32_t lids = kRings * kCorners;
  for (std::uint32_t i = 0; i < kCorners; ++i) {
    const std::uint32_t next = (i + 1) % kCorners;
    const auto at = [&](std::uint32_t ring, std::uint32_t corner) {
      return ring % kRings * kCorners + corner;
    };
    for (const std::uint32_t ring : {0u, 1u, 3u}) {
      const std::uint32_t a = at(ring, i), b = at(ring, next), c = at(ring + 1, next),
                          d = at(ring + 1, i);
      cup.triangles.insert(cup.triangles.end(), {{a, b, c}, {a, c, d}});
    }
    cup.triangles.push_back({at(2, i), at(2, next), lids});
    cup.triangles.push_back({at(3, next), at(3, i), lids + 1});
  }
  return cup;
}

TriangleMesh Pins(Random& random) {
  const double round = random.Uniform(0.004, 0.007), pin = random.Uniform(2e-4, 1e-3),
               length = random.Uniform(0.002, 0.005), slab = 0.003;
  TriangleMesh mesh = Prism(6, 1.2 * round, slab);
  for (const Vec3& at : Polygon(3, round)) {
    // They enter the slab a little.
    const double down = 0.5 * slab + 0.5 * length - 0.0005;
    mesh = Both(std::move(mesh), Moved(Prism(6, pin, length), Vec3(at.y(), -down, at.x())));
  }
  return mesh;
}

TriangleMesh MeshOf(std::string_view tool, Random& random) {
  const auto size = [&] { return random.Uniform(0.005, 0.015); };
  const double x = size(), y = size(), z = size();
  if (tool == "box") return MakeBox({x, y, z});
  if (tool == "blade") return MakeBox({random.Uniform(2e-4, 6e-4), y, z});
  if (tool == "triangle") return Prism(3, 0.6 * x, y);
  if (tool == "hexagon") return Prism(6, 0.6 * x, y);
  if (tool == "cylinder") return Prism(48, 0.6 * x, y);
  if (tool == "roof") {
    const double lean = random.Uniform(-0.2, 0.2) * x;
    const Vec3 outline[] = {{-0.5 * x, 0.0, 0.0}, {0.5 * x, 0.0, 0.0}, {lean, 0.7 * y, 0.0}};
    return Extruded(outline, z);
  }
  if (tool == "cup") return Cup(0.6 * x, random.Uniform(0.3, 0.57) * x, 0.7 * y, y);
  if (tool == "pins") return Pins(random);
  throw Error("no plain tool is called '" + std::string(tool) + "'");
}

}  // namespace

Body MakePlainTool(std::string_view tool, std::uint64_t seed) {
  Random random(seed);
  if (tool == "ball") return BallBody(random.Uniform(0.001, 0.008));
  return MakeSolidBody(std::string(tool), MeshOf(tool, random));
}

}  // namespace palpate::test
