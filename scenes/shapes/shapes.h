#pragma once

#include <cstddef>
#include <cstdint>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

// Closed meshes about the origin [m], wound counter-clockwise seen from outside.

/// Makes a box of the given side lengths: 12 triangles.
TriangleMesh MakeBox(const Vec3& size);

/// Makes an ellipsoid with vertices on its surface: an icosahedron, subdivided until it has at
/// least `triangles` (20, 80, 320, 1,280, 5,120, ...).
TriangleMesh MakeEllipsoid(const Vec3& semi_axes, std::size_t triangles);
TriangleMesh MakeSphere(double radius, std::size_t triangles);

/// Makes a pipe that begins at the origin along +z.  Its centre line is `length` long and bent by
/// `bend` towards +x (a circular arc; 0: straight).  The bend must be wider than the pipe.  The
/// mesh is not centred on the origin.
TriangleMesh MakeBentPipe(double inner_radius, double wall, double length, double bend);

/// Makes a round mould, or the tool that fits it exactly: a bowl `depth` deep with waves of
/// height `wave` in it.  Frame: the bowl's rim lies in y = 0 and its axis is y.  The mould
/// extends `thickness` below the bowl, the tool as far above it, so that at one pose the two
/// touch all over.
TriangleMesh MakeMould(bool mould, double radius, double depth, double wave, double thickness);

}  // namespace palpate
