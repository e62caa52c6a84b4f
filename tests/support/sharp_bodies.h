#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate::test {

// Bodies of sharp edges and narrow gaps, as made parts have them and scans do not [m]: 20 to 60 mm
// long, closed, wound counter-clockwise seen from outside, round the origin.  Their numbers of
// teeth, widths and slants come from a seed, so that there is always one that nobody tuned to.
//
//     comb                 gear              notched plate           die
//      _   _   _   _          _              __  ____   ___          _________
//     | | | | | | | |       _/ \_           |  \/    |_|   |        / o    o /|
//    _| |_| |_| |_| |_     /     \           >             <       /____o___/o|
//   |_________________|    \_   _/          |___/\____|~|__|       | o   o | /
//                            \_/                                   |___o___|/

/// Teeth of 1.5 to 4 mm on a back, gaps somewhat wider or narrower than they.
TriangleMesh MakeComb(std::uint64_t seed);
/// 8 to 20 teeth with straight flanks.
TriangleMesh MakeGear(std::uint64_t seed);
/// A plate 1 to 3 mm thick, each of its sides with notches, square ones and pointed ones.
TriangleMesh MakeNotchedPlate(std::uint64_t seed);
/// A cube whose faces have 1 to 6 pits, each a pyramid.
TriangleMesh MakeDie(std::uint64_t seed);

/// A ball whose radius goes up and down in steps of an eighth, as terraces do: sharp edges that run
/// every way, hollow and not.
TriangleMesh MakeTerraced(double radius, std::size_t triangles, std::uint64_t seed);

/// `outline`: a simple polygon, counter-clockwise; z from -thickness / 2 to thickness / 2.
TriangleMesh Extruded(std::span<const Vec3> outline, double thickness);

/// One body as the tool, one as the object, felt as surfaces; in the last a ball on terraces.
inline constexpr std::array<std::string_view, 6> kSharpScenes{
    "sharp-combs", "sharp-gears",     "sharp-plates",
    "sharp-dice",  "sharp-gear-comb", "sharp-terraces-ball"};
/// Of such a name, or of one with a seed: "sharp-gears:17" (else 1).  Nothing of any other.
std::optional<Scene> MakeSharpScene(std::string_view name);

}  // namespace palpate::test
