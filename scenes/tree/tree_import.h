#pragma once

#include <cstdint>
#include <string>

#include "scenes/scene.h"
#include "scenes/sphere_tree.h"
#include "scenes/tree/tree_source.h"

namespace palpate {

/// A tree whose leaves are the balls of one level of a file.
struct ImportedTree {
  SphereTree tree;     ///< frame B [m]
  std::string found;   ///< for people: which balls, how they were moved and how they fit
  std::string misfit;  ///< for people: why they may be of another mesh; empty: they fit
};

/// Reads the file that `source` names and aligns its balls with the mesh.
/// @param mesh             of the body, frame B [m].
/// @param metres_per_unit  the unit of the body's mesh file, used for the balls if the
///                         source gives none.
/// Throws Error if the file is damaged, has no such level, or is clearly of another mesh.
ImportedTree ImportTree(const TreeSource& source, const TriangleMesh& mesh, double metres_per_unit);

}  // namespace palpate
