#pragma once

#include <optional>
#include <string>

#include "scenes/scene.h"

namespace palpate {

/// Draws how far the spheres of a body's levels are from its mesh, as a PNG.  Each level is a
/// picture of the mesh, coloured by the height of the level's union of spheres over it
/// (UnionError::offset), with the level's figures below.  The levels stand side by side and share
/// one colour scale.
/// @param level  from 1: only that one; none: the last three.
/// Throws UsageError if the body has no such level, Error if the file cannot be written.
void DrawError(const Body& body, std::optional<int> level, const std::string& png_file);

/// Returns the place of a height on a picture's colour scale: -1 to 0 below the mesh, 0 on it, up
/// to 1 above it.  All decades have the same width; the scale is linear up to the smallest of them.
/// @param largest  the height at the end of the scale, a power of ten [m].
double PlaceOnScale(double height, double largest);

}  // namespace palpate
