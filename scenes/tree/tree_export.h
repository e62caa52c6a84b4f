#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "scenes/tree/sphere.h"

namespace palpate {

/// Returns the balls as a surface that any viewer shows, each a small icosphere in its own colour:
/// a binary little-endian PLY.
/// @param metres_per_unit  the unit of the file.
std::vector<std::uint8_t> ToPly(const std::vector<Sphere>& balls, double metres_per_unit);

/// Returns the balls as binary glTF 2.0, in metres: one node for each ball, in one of sixteen
/// colours, which all share one icosphere.
/// @param name  of the parent node.
std::vector<std::uint8_t> ToGlb(const std::vector<Sphere>& balls, const std::string& name);

/// How to write a tree.
struct TreeExportOptions {
  /// From 1, the coarsest below the root, as palpate-scene info counts.  None: the finest level for
  /// a .ply or .glb, all levels for a .sph.
  std::optional<int> level{};
  std::string unit{};  ///< for a .sph or .ply, one of kUnits; empty: mm
};

/// Returns the file's ending, ".sph", ".ply" or ".glb".  Throws UsageError for any other.
std::string ExportFormatOf(const std::string& file);

/// Returns the bytes of a file with a body's tree, in the body's frame, in the format of the file's
/// ending (sph_file.h).  Throws Error or UsageError.
std::vector<std::uint8_t> ExportTree(const Body& body, const TreeExportOptions& options,
                                     const std::string& file);

}  // namespace palpate
