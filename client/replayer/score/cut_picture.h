#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "client/replayer/verify/verify.h"
#include "scenes/grid/solid_surface.h"

namespace palpate {

/// The surface of what a trial left, coarse enough for a page, and how far off the target's it is.
struct CutPicture {
  std::vector<Vec3> vertices;  ///< W [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> colours;  ///< 0xRRGGBB of the material, of each vertex
  /// Distance of each vertex to the target's surface: above 0 where the target is free, so that
  /// what lies there should have gone; below 0 within what should have stayed [m].
  std::vector<double> off;
};

/// Beyond so much, `off` is no farther: the ends of the page's scale [m].
inline constexpr double kMostOff = 0.5e-3;

/// Vertices of cells that are so wide that about 12,000 are left, each the mean of its own.
/// @param surfaces  of each solid that the trial left.   @param of_target  the target's.
CutPicture PictureOf(const SolidsCut& trial, const std::vector<SolidSurface>& surfaces,
                     const SolidsCut& target, const std::vector<SolidSurface>& of_target);

/// The same for score_cut.js: arrays as base64 of little-endian bytes.
struct PackedPicture {
  Vec3 middle = Vec3::Zero();  ///< W [m]
  double reach = 1.0;          ///< of all from the middle [m]
  std::string places;          ///< int16 of x, y, z from the middle, 32767 at `reach`
  std::string off;             ///< int8, 127 at kMostOff
  std::string colours;         ///< uint8 of red, green, blue
  std::string corners;         ///< uint32
};
PackedPicture Packed(const CutPicture& picture);

}  // namespace palpate
