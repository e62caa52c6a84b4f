#pragma once

#include <cstdint>
#include <vector>

#include "common/math/pose.h"
#include "scenes/grid/solid_surface.h"

namespace palpate {

/// Encodes a block's surface for viewers, in some 500 bytes.  Little endian:
///
///     u16 vertices V (at most 5,916), u16 quads Q, u16 triangles T (2 Q + T at most 6,144),
///     V times 3 u8: a vertex lies at begin + h (u / 21 - 2) on each axis,
///     Q times 4 indices, whose triangles are 0 1 2 and 0 2 3; T times 3 indices:
///         u8 if V <= 256, else u16; counter-clockwise seen from the free side,
///     materials, u8, as in the solid's grid: one if all are the same, else Q + T.
///
/// If there is no surface, only the three counts are written.  A step of h/21 is 2.4 um if h is 50
/// um; a block is 168 steps wide, so shared vertices of neighbouring blocks have equal places.
/// @param begin  origin of the block in the solid's frame [m].   @param code  replaced.
void EncodeSurface(const SolidSurface& surface, const Vec3& begin, double spacing,
                   std::vector<std::uint8_t>& code);

}  // namespace palpate
