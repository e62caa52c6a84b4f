#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "scenes/scene.h"

namespace palpate::test {

/// Tools that stand on a plane by their foot, y = const, with their centroid above it: so a hand
/// that presses one straight down feels a force through the centroid, and no torque.  5 to 15 mm.
///   box, blade      a blade is 0.2 to 0.6 mm thick
///   triangle, hexagon, cylinder   upright prisms; the cylinder has 48 corners
///   roof            a triangular prism that lies on a side
///   cup             a ring below a ceiling
///   pins            three pins below a slab
///   ball            a single sphere
inline constexpr std::array<std::string_view, 9> kPlainTools{
    "box", "blade", "triangle", "hexagon", "cylinder", "roof", "cup", "pins", "ball"};

/// @param tool  one of the above.
Body MakePlainTool(std::string_view tool, std::uint64_t seed);

}  // namespace palpate::test
