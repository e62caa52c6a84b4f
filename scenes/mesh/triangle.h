#pragma once

#include <cstddef>

#include <Eigen/Geometry>

#include "scenes/scene.h"

namespace palpate {

/// A triangle's corners, counter-clockwise seen from outside.
struct Triangle {
  Vec3 a, b, c;
  Vec3 Middle() const { return (a + b + c) / 3.0; }
  /// Returns the outward normal, whose length is twice the area.
  Vec3 Across() const { return (b - a).cross(c - a); }
  double Area() const { return 0.5 * Across().norm(); }
};

inline Triangle TriangleOf(const TriangleMesh& mesh, std::size_t triangle) {
  const auto& [i, j, k] = mesh.triangles[triangle];
  return {mesh.vertices[i], mesh.vertices[j], mesh.vertices[k]};
}

/// Returns the box of all corners of triangles; empty if there are none.
inline Eigen::AlignedBox3d BoxOf(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) box.extend(mesh.vertices[v]);
  }
  return box;
}

}  // namespace palpate
