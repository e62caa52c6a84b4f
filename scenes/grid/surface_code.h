#pragma once

#include <cstdint>
#include <vector>

#include "common/math/pose.h"
#include "scenes/grid/solid_surface.h"

namespace palpate {

/// A block's surface as it travels to viewers.  Little endian:
///
///     u16 vertices V (at most 5,916), u16 triangles T (at most 6,144),
///     V times 3 u16: (p - block's beginning) / h * 256 + 1024: from 4 h before it, in h / 256,
///     T times 3 indices, u8 where V <= 256, else u16: counter-clockwise seen from where it is
///     free, materials, u8: one where all are the same, else T: as the solid's grid numbers them.
///
/// Nothing but the two counts where there are no triangles.

/// @param begin  of the block in the solid's frame [m].  Replaces what `code` holds, and uses its
///               storage again.
void EncodeSurface(const SolidSurface& surface, const Vec3& begin, double spacing,
                   std::vector<std::uint8_t>& code);

}  // namespace palpate
