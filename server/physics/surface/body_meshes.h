#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "common/math/pose.h"
#include "scenes/sphere_tree.h"
#include "server/physics/step_types.h"
#include "server/physics/surface/contact_mesh.h"
#include "server/physics/surface/hull_tree.h"

namespace palpate {

/// True where an object's mesh decides its contact: it is rigid and stays.  What yields or is
/// scraped off has its compliance and hardness by leaf, so its leaves decide.
bool IsFeltByMesh(const PlacedTree& object);

/// A ContactMesh and its tree.  `radius` [m] rounds it: of a spherical tool, whose mesh is a point.
struct MeshWithTree {
  explicit MeshWithTree(ContactMesh m, double rounding = 0.0)
      : mesh(std::move(m)), tree(mesh), radius(rounding) {}
  MeshWithTree(const MeshWithTree&) = delete;
  MeshWithTree& operator=(const MeshWithTree&) = delete;

  const ContactMesh mesh;
  const HullTree tree;
  const double radius;
};

/// The meshes of all objects of a scene that are felt by them, in W, as one.  Immutable.
class ObjectMeshes {
 public:
  /// Null where no object is felt by its mesh.  Throws Error where such an object has no mesh.
  static std::unique_ptr<const ObjectMeshes> Make(std::span<const PlacedTree> objects);

  const MeshWithTree& meshes() const { return meshes_; }
  /// Leaf of the forest that is nearest to a triangle: its material is the triangle's.
  std::int32_t LeafOf(std::uint32_t triangle) const { return leaf_[triangle]; }
  /// Whether a point of W, on no surface, lies inside an object: its mesh winds round it, by more
  /// than half where it is open.  Not real-time.
  bool Hold(const Vec3& p_W) const;

 private:
  ObjectMeshes(std::span<const PlacedMesh> placed, std::span<const PlacedTree* const> object,
               std::span<const std::int32_t> first_leaf);

  MeshWithTree meshes_;
  std::vector<std::int32_t> leaf_;
  std::vector<Eigen::AlignedBox3d> boxes_;  ///< of each mesh
};

/// The mesh of a tool about its reference point; of a tool that is a single ball, its centre with
/// its radius.  Throws Error where another tool has no mesh.
std::unique_ptr<const MeshWithTree> MakeToolMesh(const TriangleMesh* mesh, const SphereTree& tree,
                                                 const Vec3& reference);

}  // namespace palpate
