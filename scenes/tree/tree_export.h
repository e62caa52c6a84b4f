#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "scenes/tree/sphere.h"

namespace palpate {

/// Balls as a surface that any viewer shows, a ball a small icosphere in a colour of its own: a
/// binary little-endian PLY.
/// @param metres_per_unit  what a number in the file is to mean.
std::vector<std::uint8_t> ToPly(const std::vector<Sphere>& balls, double metres_per_unit);

/// The same as binary glTF 2.0, in metres: a node for each ball, in one of sixteen colours, all of
/// which show the same icosphere.
/// @param name  of the node that has them all below it.
std::vector<std::uint8_t> ToGlb(const std::vector<Sphere>& balls, const std::string& name);

/// What a tree is written as.
struct TreeExportOptions {
  /// From 1, the coarsest below the root, as palpate-scene info counts; none: the finest of a .ply
  /// or .glb, all levels of a .sph.
  std::optional<int> level{};
  std::string unit{};  ///< of a .sph or .ply, one of kUnits; empty: mm
};

/// ".sph", ".ply" or ".glb", by the file's ending.  Throws UsageError where it is another.
std::string ExportFormatOf(const std::string& file);

/// The bytes of a file of a body's tree, in its frame, in the format of the file's ending
/// (sph_file.h).  Throws Error or UsageError.
std::vector<std::uint8_t> ExportTree(const Body& body, const TreeExportOptions& options,
                                     const std::string& file);

}  // namespace palpate
