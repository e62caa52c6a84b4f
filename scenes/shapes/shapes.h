#pragma once

#include <cstddef>
#include <cstdint>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

/// Changes with every change of what a shape looks like, so that cached scenes are built anew.
inline constexpr std::uint32_t kShapesVersion = 8;
/// Of the margins of those that have one.
inline constexpr std::uint32_t kMarginVersion = 1;

// Closed meshes round the origin [m], wound counter-clockwise seen from outside.

/// Box of the given side lengths: 12 triangles.
TriangleMesh MakeBox(const Vec3& size);

/// Ellipsoid with vertices on its surface: an icosahedron, subdivided until it has at least
/// `triangles` of them (20, 80, 320, 1,280, 5,120, ...).
TriangleMesh MakeEllipsoid(const Vec3& semi_axes, std::size_t triangles);
TriangleMesh MakeSphere(double radius, std::size_t triangles);

/// Pipe from the origin along +z, its curve `length` long and bent by `bend` towards +x (an arc of
/// a circle; 0: straight).  The bend must be wider than the pipe.  Not round the origin.
TriangleMesh MakeBentPipe(double inner_radius, double wall, double length, double bend);

/// Round mould that a tool fits exactly: a bowl `depth` deep with waves of the height `wave` in it.
/// Frame: the bowl's rim lies in y = 0 and its axis is y; below it there are `thickness` of
/// material, above it those of the tool, so that at one pose the two touch all over.
TriangleMesh MakeMould(bool mould, double radius, double depth, double wave, double thickness);

}  // namespace palpate
