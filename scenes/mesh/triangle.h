#pragma once

#include <cstddef>

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

}  // namespace palpate
