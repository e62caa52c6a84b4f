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

// Bodies with sharp edges and narrow gaps, like manufactured parts and unlike scans [m]: 20 to 60
// mm long, closed, counter-clockwise seen from outside, centred at the origin.  Their numbers of
// teeth, widths and slants depend on a seed, so that there is always an untuned one.
//
//     comb                 gear              notched plate           die
//      _   _   _   _          _              __  ____   ___          _________
//     | | | | | | | |       _/ \_           |  \/    |_|   |        / o    o /|
//    _| |_| |_| |_| |_     /     \           >             <       /____o___/o|
//   |_________________|    \_   _/          |___/\____|~|__|       | o   o | /
//                            \_/                                   |___o___|/

/// Teeth of 1.5 to 4 mm on a back, with gaps a little wider or narrower than the teeth.
TriangleMesh MakeComb(std::uint64_t seed);
/// 8 to 20 teeth with straight flanks.
TriangleMesh MakeGear(std::uint64_t seed);
/// A plate 1 to 3 mm thick, with square and pointed notches on each side.
TriangleMesh MakeNotchedPlate(std::uint64_t seed);
/// A cube whose faces have 1 to 6 pits, each a pyramid.
TriangleMesh MakeDie(std::uint64_t seed);

/// A ball whose radius rises and falls in steps of an eighth, like terraces: sharp convex and
/// concave edges in every direction.
TriangleMesh MakeTerraced(double radius, std::size_t triangles, std::uint64_t seed);

/// Extrudes a simple polygon, counter-clockwise, to z from -thickness / 2 to thickness / 2.
TriangleMesh Extruded(std::span<const Vec3> outline, double thickness);

/// Scenes of one body as tool and one as object, in contact as surfaces, or a ball on terraces.
inline constexpr std::array<std::string_view, 6> kSharpScenes{
    "sharp-combs", "sharp-gears",     "sharp-plates",
    "sharp-dice",  "sharp-gear-comb", "sharp-terraces-ball"};
/// Makes the scene of such a name, with an optional seed: "sharp-gears:17" (default 1).  Returns
/// nothing for any other name.
std::optional<Scene> MakeSharpScene(std::string_view name);

}  // namespace palpate::test
