#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scenes/grid/solid_surface.h"
#include "server/physics/cut/cutting.h"
#include "server/physics/surface/contact_bodies.h"

namespace palpate {

/// The boxes of a solid's blocks as one body.  Contact sees a solid that a bur can cut
/// through these boxes, because whatever is cut, what is left of a block lies in its box.
/// What it then feels is the surface that viewers draw (scenes/grid/solid_surface.h), one
/// body for each block.
ContactBody BlocksOf(const CutSolid& solid);

/// The surface of one block, in the frame of its solid.  It includes the neighbouring triangles,
/// which only serve the normal cones of the block's own.
struct BlockBody {
  struct Of {
    std::int32_t solid;   ///< index, among the scene's bodies, of the solid's boxes
    HullTree::Node node;  ///< the block's node in their tree
    std::int32_t block;
  };
  struct Scratch {
    void Reserve();

    SolidSurface surface;
    ContactMesh::Scratch mesh;
    HullTree::Scratch tree;
  };

  /// Allocates storage for limits::mesh::kMostOfBlock triangles.
  void Reserve();
  /// Makes the body from the scratch's surface, whose first `own` triangles are the block's own.
  /// Real-time if the storage suffices.
  void Assign(const Of& block, std::size_t own, Scratch& scratch);

  ContactShape shape{ContactMesh(), HullTree()};
  std::vector<std::uint8_t> materials;  ///< for each of the block's own triangles
  Of of{};
};

/// The bodies of all blocks of a scene's solids before anything is cut; most of a solid never is.
/// The sessions of a scene share them: 78 MB for a tooth of 10 mm at 50 um.
struct UncutBodies {
  UncutBodies() = default;
  /// `solids` and `boxes` must outlive this object.
  UncutBodies(std::span<const CutSolid> solids, std::span<const ContactBody> boxes,
              std::size_t first_body);

  std::span<const CutSolid> solids;
  std::span<const ContactBody> boxes;  ///< for each solid, its BlocksOf
  std::int32_t first_body = 0;         ///< index of the first of them among the scene's bodies
  /// For each solid, for each block, the index of its body; -1 if the block is empty.
  std::vector<std::vector<std::int32_t>> place;
  std::vector<BlockBody> bodies;
};

}  // namespace palpate
