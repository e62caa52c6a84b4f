#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

BurProfile BallBur(double radius);
/// Returns a tapered bur, or a straight one if both radii are equal; edges are rounded as far as
/// there is room.  [m]
BurProfile ConeBur(double tip_radius, double top_radius, double length, double rounding);
/// Returns a bur that is widest at its tip, half a ball, and half as wide at its top.  [m]
BurProfile PearBur(double radius, double length);
/// Returns a pointed bur that widens along a parabola up to three fifths of its length, and
/// narrows above.  [m]
BurProfile FlameBur(double radius, double length);

/// Returns a hollow cylinder: a bore as deep as the bur, but for a roof as thick as its
/// wall is.  [m]
BurProfile TrephineBur(double radius, double wall, double length, double rounding);

/// Makes the mesh of a tool: the bur at the origin, its axis along y, on a shank in a handle.
/// @param handle  y at the end of the handle [m].
TriangleMesh MakeBur(const BurProfile& bur, double handle);

/// A bur in the terms of the scene's shape "bur" (shape_kinds.h): its kind and dimensions.
struct NamedBur {
  std::string_view kind;
  double diameter = 0.0, length = 0.0, tip_diameter = 0.0, rounding = 0.0;  ///< [m]
};
/// Returns the bur of an ISO 6360 number: shape (7th to 9th digit) / largest diameter in 1/10 mm
/// (13th to 15th), as "237/014".  Shapes and head lengths are those of Komet's FG diamonds
/// (Viking's catalogue of 2019); where that gives a range of lengths, the length is the diameter,
/// clamped to the range.  The sides of a taper are at 2 degrees to the axis, as in Komet's 856.
/// Throws Error that lists the known numbers.
NamedBur BurOfIso(const std::string& name);

}  // namespace palpate
