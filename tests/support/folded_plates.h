#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "scenes/scene.h"

namespace palpate::test {

// Bodies whose flat sides are plates of flat_plates.h in any of their tessellations, extended along
// z.  Where sides meet, their vertices coincide if the tessellation's do, else they lie on each
// other's edges.

/// Makes a groove: two sides that meet in the z axis and open towards +y, each at an angle to the
/// plane x = 0.
///
///        \       |       /
///         \      |      /
///     left \     y     / right         all sides are 2 kPlateHalf long and wide
///           \    | a  /
///            \   |   /    a: half_angle [rad], of each side
///             \  |  /
///              \ | /
///               \./---- x
///
/// @param right, left  seeds of the sides; if equal, the groove is its own mirror image.
TriangleMesh MakeGroove(std::string_view tessellation, double half_angle, std::uint64_t right,
                        std::uint64_t left);

/// Makes a block with a hole along z, 2 kPlateHalf long, whose sides are those of a polygon, all
/// divided alike.
/// Across z the plates are squeezed to the polygon's sides; along z they keep their lengths.
/// @param outline  a convex polygon round the origin, counter-clockwise.
TriangleMesh MakeHole(std::string_view tessellation, std::span<const Vec3> outline,
                      std::uint64_t seed);

}  // namespace palpate::test
