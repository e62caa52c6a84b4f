#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

BurProfile BallBur(double radius);
/// Tapered, or straight where both radii are the same; edges are rounded as far as there is room.
/// [m]
BurProfile ConeBur(double tip_radius, double top_radius, double length, double rounding);
/// Widest at its tip, which is half a ball, and half as wide at its top.  [m]
BurProfile PearBur(double radius, double length);
/// A point that bulges, by a parabola, up to three fifths of its length, and is drawn in above.
/// [m]
BurProfile FlameBur(double radius, double length);

/// A hollow cylinder.  Its bore is as deep as it is long, but for a roof as thick as its wall.  [m]
BurProfile TrephineBur(double radius, double wall, double length, double rounding);

/// A tool: the bur at the origin, its axis along y, on a shank in a handle.
/// @param handle  where the handle ends [m].
TriangleMesh MakeBur(const BurProfile& bur, double handle);

/// A bur as the scene's shape "bur" has it (shape_kinds.h): its kind, and the numbers of it.
struct NamedBur {
  std::string_view kind;
  double diameter = 0.0, length = 0.0, tip_diameter = 0.0, rounding = 0.0;  ///< [m]
};
/// A bur by its ISO 6360 number: shape (7th to 9th digit) / greatest diameter in 1/10 mm (13th to
/// 15th), as "237/014".  Shapes and lengths of heads are those of Komet's FG diamonds (Viking's
/// catalogue of 2019); of a range of lengths, the diameter or what of the range is nearest to it.
/// A taper is 2 degrees to the axis, as Komet's 856 has it.  Throws Error that lists what is known.
NamedBur BurOfIso(const std::string& name);

}  // namespace palpate
