#include "scenes/importer/polygons.h"

#include <algorithm>
#include <string>
#include <utility>

#include <Eigen/Core>

#include "common/error.h"
#include "scenes/importer/mesh_text.h"

namespace palpate {
namespace {

using Vec2 = Eigen::Vector2d;

struct Corner {
  std::uint32_t vertex;
  Vec2 p;
};

/// Returns twice the signed area of a triangle, positive if it turns left.
double Turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 u = b - a, v = c - a;
  return u.x() * v.y() - u.y() * v.x();
}

/// Projects a polygon along the main axis of its normal, so that it turns left.
std::vector<Corner> Flattened(const std::vector<Vec3>& vertices,
                              std::span<const std::uint32_t> polygon) {
  Vec3 normal = Vec3::Zero();  // by Newell's method
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 a = vertices[polygon[i]] - vertices[polygon[0]];
    normal += a.cross(vertices[polygon[(i + 1) % polygon.size()]] - vertices[polygon[0]]);
  }
  int along = 0;
  normal.cwiseAbs().maxCoeff(&along);
  int x = (along + 1) % 3, y = (along + 2) % 3;
  if (normal[along] < 0.0) std::swap(x, y);
  std::vector<Corner> flat;
  for (const std::uint32_t v : polygon) flat.push_back({v, {vertices[v][x], vertices[v][y]}});
  return flat;
}

/// Returns whether a corner can be cut off: it turns left, and its triangle contains
/// no other corner.
bool IsEar(const std::vector<Corner>& polygon, std::size_t at) {
  const std::size_t n = polygon.size();
  const Vec2 &a = polygon[(at + n - 1) % n].p, &b = polygon[at].p, &c = polygon[(at + 1) % n].p;
  if (!(Turn(a, b, c) > 0.0)) return false;
  return std::ranges::none_of(polygon, [&](const Corner& other) {
    const Vec2& p = other.p;
    return p != a && p != b && p != c && Turn(a, b, p) >= 0.0 && Turn(b, c, p) >= 0.0 &&
           Turn(c, a, p) >= 0.0;
  });
}

/// Cuts off ears, beginning at the second corner; a convex polygon becomes a fan.
void Cut(const std::vector<Vec3>& vertices, std::span<const std::uint32_t> polygon,
         TriangleMesh& mesh) {
  if (polygon.size() == 3) mesh.triangles.push_back({polygon[0], polygon[1], polygon[2]});
  if (polygon.size() <= 3) return;
  std::vector<Corner> left = Flattened(vertices, polygon);
  std::size_t at = 1, passed = 0;
  while (left.size() > 3) {
    const std::size_t n = left.size();
    // A polygon that intersects itself or has no area may have no ear: then cut off any corner.
    if (!IsEar(left, at % n) && passed++ < n) {
      ++at;
      continue;
    }
    at %= n;
    passed = 0;
    mesh.triangles.push_back(
        {left[(at + n - 1) % n].vertex, left[at].vertex, left[(at + 1) % n].vertex});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(at));
  }
  mesh.triangles.push_back({left[0].vertex, left[1].vertex, left[2].vertex});
}

}  // namespace

ImportedMesh TrianglesOf(Polygons&& polygons) {
  ImportedMesh read;
  read.mesh.vertices = std::move(polygons.vertices);
  const std::size_t vertices = read.mesh.vertices.size();
  std::vector<std::uint32_t> first{0};  // first triangle of each polygon, and the end
  std::uint32_t begin = 0;
  for (const std::uint32_t end : polygons.ends) {
    const std::span polygon = std::span(polygons.corners).subspan(begin, end - begin);
    for (const std::uint32_t v : polygon) {
      if (v < vertices) continue;
      throw Error("its face " + std::to_string(first.size()) + " names vertex " +
                  std::to_string(std::size_t{v} + 1) + " of " + std::to_string(vertices) +
                  kExportAgain);
    }
    Cut(read.mesh.vertices, polygon, read.mesh);
    first.push_back(static_cast<std::uint32_t>(read.mesh.triangles.size()));
    begin = end;
  }
  for (MeshGroup& group : polygons.groups) {
    read.groups.push_back({std::move(group.name), first[group.begin], first[group.end]});
  }
  return read;
}

}  // namespace palpate
