#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "scenes/sphere_tree.h"
#include "server/physics/cut/cutting.h"
#include "server/physics/step_types.h"
#include "server/physics/surface/contact_mesh.h"
#include "server/physics/surface/hull_tree.h"

namespace palpate {

/// True where an object's mesh decides its contact: it is rigid.  What yields has its compliance by
/// leaf, so its leaves decide.
bool IsFeltByMesh(const PlacedTree& object);

/// What contact knows of a body: triangles with a tree over them, rounded by a radius [m], which is
/// 0 but for a spherical tool, whose mesh is a point.
struct ContactBody {
  explicit ContactBody(ContactMesh m, double rounding = 0.0)
      : mesh(std::move(m)), tree(mesh), radius(rounding) {}
  ContactBody(ContactMesh m, HullTree t) : mesh(std::move(m)), tree(std::move(t)) {}

  ContactMesh mesh;
  HullTree tree;
  double radius = 0.0;
  /// Of a tool, the part that solids are felt by as long as it cuts: all of it but the head of a
  /// bur or an edge.  None where it is all head.
  std::optional<HullTree::Node> shank = tree.root();
  /// Of each triangle of an object, the nearest leaf of the forest: its material is the triangle's.
  std::vector<std::int32_t> leaf;
};

/// The objects of a scene that are felt by their meshes, each a body in W.  Throws Error where such
/// an object has no mesh.
std::vector<ContactBody> MakeBodies(std::span<const PlacedTree> objects);

/// Whether a point of W, on no surface, lies inside a body: its mesh winds round it, by more than
/// half where it is open.  Not real-time.
bool Hold(std::span<const ContactBody> bodies, const Vec3& p_W);

/// The mesh of a tool about its reference point; of a tool that is a single ball, its centre with
/// its radius.  Throws Error where another tool has no mesh.
/// `cutting`: of a bur; else null.
std::unique_ptr<const ContactBody> MakeToolBody(const TriangleMesh* mesh, const SphereTree& tree,
                                                const Vec3& reference,
                                                const Cutting* cutting = nullptr);

}  // namespace palpate
