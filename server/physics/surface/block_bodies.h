#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scenes/grid/solid_surface.h"
#include "server/physics/cut/cutting.h"
#include "server/physics/surface/contact_bodies.h"

namespace palpate {

/// Solids that burs cut are felt by the surface that viewers draw (scenes/grid/solid_surface.h),
/// each block of their lattices by a body of its own.  Contact knows of a solid, whatever is cut,
/// the boxes of its blocks, in W: what is left of a block lies in its box.
ContactBody BlocksOf(const CutSolid& solid);

/// The surface of a block as a body in W: its triangles, and for their normal cones the neighbours'
/// round them.
struct BlockBody {
  struct Of {
    std::int32_t solid;   ///< number of the solid's boxes among the scene's bodies
    HullTree::Node node;  ///< of the block, among them
    std::int32_t block;
  };
  struct Scratch {
    void Reserve();

    SolidSurface surface;
    ContactMesh::Scratch mesh;
    HullTree::Scratch tree;
  };

  /// Storage for limits::mesh::kMostOfBlock triangles.
  void Reserve();
  /// Made of the scratch's surface, whose first `own` triangles are the block's.  Real-time within
  /// the storage.
  void Assign(const Of& block, std::size_t own, const Pose& X_WB, Scratch& scratch);

  ContactBody body{ContactMesh(), HullTree()};
  std::vector<std::uint8_t> materials;  ///< of the block's own triangles
  Of of{};
};

/// Bodies of all blocks of a scene's solids as they are before anything is cut: most of a solid
/// never is.  Of a tooth of 10 mm at 50 um 78 MB, which the sessions of a scene share.
class UncutBodies {
 public:
  UncutBodies() = default;
  /// `boxes`: of each solid (BlocksOf); `first_body`: number of the first of them among the scene's
  /// bodies.  What it is given outlives it.
  UncutBodies(std::span<const CutSolid> solids, std::span<const ContactBody> boxes,
              std::size_t first_body);

  std::span<const CutSolid> solids() const { return solids_; }
  std::span<const ContactBody> boxes() const { return boxes_; }
  std::int32_t first_body() const { return first_body_; }
  /// The place of a block's body; -1 where there is nothing of it.
  std::int32_t PlaceOf(std::size_t solid, std::size_t block) const { return place_[solid][block]; }
  const BlockBody& operator[](std::size_t place) const { return bodies_[place]; }

 private:
  std::span<const CutSolid> solids_;
  std::span<const ContactBody> boxes_;
  std::int32_t first_body_ = 0;
  std::vector<std::vector<std::int32_t>> place_;  ///< of each solid's blocks
  std::vector<BlockBody> bodies_;
};

}  // namespace palpate
