#pragma once

#include <cstdint>
#include <string>

#include "scenes/scene.h"
#include "scenes/sphere_tree.h"
#include "scenes/tree/tree_source.h"

namespace palpate {

/// Changes with every change of what ImportTree makes, so that cached scenes are built anew.
inline constexpr std::uint32_t kTreeImportVersion = 1;

/// A tree whose leaves are the balls of a file's level.
struct ImportedTree {
  SphereTree tree;     ///< frame B [m]
  std::string found;   ///< for people: which balls, how they were moved and how they fit
  std::string misfit;  ///< for people: why they may be of another mesh; empty: they fit
};

/// Reads the file that `source` names and brings its balls to the mesh.
/// @param mesh             of the body, frame B [m].
/// @param metres_per_unit  of the file, where the source says none: what a number in the mesh's
///                         file means.
/// Throws Error where the file is damaged, has no such level, or is clearly of something else.
ImportedTree ImportTree(const TreeSource& source, const TriangleMesh& mesh, double metres_per_unit);

}  // namespace palpate
