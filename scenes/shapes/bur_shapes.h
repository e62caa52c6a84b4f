#pragma once

#include "scenes/scene.h"

namespace palpate {

BurProfile BallBur(double radius);
/// Tapered, or straight where both radii are the same; edges are rounded as far as there is room.
/// [m]
BurProfile ConeBur(double tip_radius, double top_radius, double length, double rounding);

/// A tool: the bur at the origin, its axis along y, on a shank in a handle.
/// @param handle  where the handle ends [m].
TriangleMesh MakeBur(const BurProfile& bur, double handle);

}  // namespace palpate
