#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "client/replayer/verify/verify.h"

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
CutPicture PictureOf(const SolidsCut& trial, const SolidsCut& target);

/// For score_cut.js, an object of JSON: numbers as base64 of little-endian bytes.
std::string JsonOf(const CutPicture& picture, const std::string& name);

}  // namespace palpate
