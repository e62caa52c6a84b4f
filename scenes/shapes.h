#pragma once

#include <cstddef>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

// Closed meshes round the origin [m], wound counter-clockwise seen from outside.

/// Box of the given side lengths: 12 triangles.
TriangleMesh MakeBox(const Vec3& size);

/// Ellipsoid with vertices on its surface: an icosahedron, subdivided until it has at least
/// `triangles` of them (20, 80, 320, 1,280, 5,120, ...).
TriangleMesh MakeEllipsoid(const Vec3& semi_axes, std::size_t triangles);
TriangleMesh MakeSphere(double radius, std::size_t triangles);

}  // namespace palpate
