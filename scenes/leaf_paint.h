#pragma once

#include <cstdint>
#include <vector>

#include "scenes/files/scene_file.h"
#include "scenes/mesh/mesh_import.h"
#include "scenes/scene.h"

namespace palpate {

/// Changes with what named parts paint, so that older cached scenes that have any are built anew.
inline constexpr std::uint32_t kGroupPaintVersion = 2;

/// Gives every leaf of an object its material: fills body.materials and body.leaf_material.
///
/// A named part of the mesh counts where it is exposed: gum inside a crown makes no leaf soft.
///
/// A Young's modulus E of a layer of thickness L becomes the row stiffness E A / L of a leaf, A the
/// exposed surface that a leaf of that material stands for (their mean): a leaf is an elastic
/// column under its piece of surface, and many leaves pressed together are as stiff as the layer
/// above them (the elastic foundation of Johnson, Contact Mechanics (1985), 4.3).  Along sharp
/// edges, where leaves crowd, the layer comes out stiffer than it is.
/// @param body  with mesh and tree.   @param groups  named parts of its mesh.
/// Throws Error where a region paints no leaf, and names the region's line.
void PaintLeaves(const BodyDescription& description, const std::vector<MeshGroup>& groups,
                 Body& body);

}  // namespace palpate
