#pragma once

#include <optional>
#include <string>

#include "scenes/scene.h"

namespace palpate {

/// Draws how far the spheres of a body's levels are from its mesh, side by side: the mesh, coloured
/// by the height of each level's union over it (UnionError::offset), with the level's figures below
/// it and one scale for all.  Writes a PNG.
/// @param level  from 1, only that one; none: the last three.
/// Throws UsageError where the body has no such level, Error where the file cannot be written.
void DrawError(const Body& body, std::optional<int> level, const std::string& png_file);

/// Where a height is on the scale of a picture, -1 to 1: below the mesh, on it, above it.  A decade
/// is as wide as any other, and what is below the smallest as it.
/// @param largest  the scale's end, a power of ten [m].
double PlaceOnScale(double height, double largest);

}  // namespace palpate
