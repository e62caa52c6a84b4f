#pragma once

#include <cstdint>
#include <vector>

#include "scenes/files/scene_file.h"
#include "scenes/mesh/mesh_import.h"
#include "scenes/scene.h"

namespace palpate {

/// Gives every leaf of an object its material: fills body.materials and body.leaf_material.
///
/// Only the exposed surface of a named part counts: gum inside a crown makes no leaf soft.
///
/// A Young's modulus E of a layer of thickness L becomes the row stiffness E A / L of a leaf, where
/// A is the mean exposed surface per leaf of that material.  So a leaf is an elastic column under
/// its piece of surface, and many leaves pressed together are as stiff as the layer above them (the
/// elastic foundation of Johnson, Contact Mechanics (1985), 4.3).  Along sharp edges, where leaves
/// are dense, the layer is stiffer than it should be.
/// @param body  with mesh and tree.   @param groups  named parts of its mesh.
/// Throws Error, which names the region's line, if a region paints no leaf.
void PaintLeaves(const BodyDescription& description, const std::vector<MeshGroup>& groups,
                 Body& body);

}  // namespace palpate
