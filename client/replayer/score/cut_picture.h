#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "client/replayer/verify/verify.h"
#include "scenes/grid/solid_surface.h"

namespace palpate {

/// The surface that a trial left, simplified for a page, with its distance from the
/// target's surface.
struct CutPicture {
  std::vector<Vec3> vertices;  ///< W [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> colours;  ///< 0xRRGGBB of the material, one per vertex
  /// Signed distance of each vertex to the target's surface [m]: positive outside the target
  /// (material that should have been removed), negative inside (material removed in excess).
  std::vector<double> off;
};

/// `off` is clamped to this distance, the end of the page's scale [m].
inline constexpr double kMostOff = 0.5e-3;

/// Simplifies by vertex clustering: cells are so wide that about 12,000 vertices remain, each the
/// mean of its cell.
/// @param surfaces  of each solid that the trial left.   @param of_target  the target's.
CutPicture PictureOf(const SolidsCut& trial, const std::vector<SolidSurface>& surfaces,
                     const SolidsCut& target, const std::vector<SolidSurface>& of_target);

/// A CutPicture for score_cut.js: arrays as base64 of little-endian bytes.
struct PackedPicture {
  Vec3 middle = Vec3::Zero();  ///< W [m]
  double reach = 1.0;          ///< largest distance of a vertex from the middle [m]
  std::string places;          ///< int16 x, y, z from the middle; 32767 is `reach`
  std::string off;             ///< int8; 127 is kMostOff
  std::string colours;         ///< uint8 of red, green, blue
  std::string corners;         ///< uint32
};
PackedPicture Packed(const CutPicture& picture);

}  // namespace palpate
