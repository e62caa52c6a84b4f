#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "scenes/scene.h"

namespace palpate::test {

// Plates whose top is exactly flat, however it is divided into triangles.  So what a tool feels on
// them is known: without friction a force along the normal, whatever triangle carries it.

inline constexpr double kPlateHalf = 0.04;       ///< half the sides in x and z [m]
inline constexpr double kPlateThickness = 0.01;  ///< the top is y = 0 [m]

/// How the top, and in the same way the bottom, is divided:
///   quad         two triangles
///   strips       3 to 120 strips of equal width, from side to side
///   grid         5 x 5 to 60 x 60 squares, with equal diagonals
///   diagonals    such a grid with moved corners, and diagonals at random
///   fan          12 to 300 triangles round one point of the top
///   needles      strips whose widths are spread evenly over the decades from 1 nm to 10 mm
///   graded       a grid about a point, with such widths along both axes: squares of 1 nm, needles
///                of 1 nm by 10 mm
///   splits       triangles divided in three at random points, again and again
///   delaunay     the Delaunay triangulation of random points
///   t-junctions  4 to 64 grids of their own side by side, whose vertices meet edges of others
///   soup         `diagonals` where each triangle has vertices of its own
inline constexpr std::array<std::string_view, 11> kTessellations{
    "quad",   "strips", "grid",     "diagonals",   "fan", "needles",
    "graded", "splits", "delaunay", "t-junctions", "soup"};

/// Makes a plate.  Closed: vertices coincide, bit for bit, where triangles meet; of t-junctions a
/// vertex may lie within the edge of another triangle, exactly on it.
/// @param tessellation  one of the above.
TriangleMesh MakePlate(std::string_view tessellation, std::uint64_t seed);

}  // namespace palpate::test
