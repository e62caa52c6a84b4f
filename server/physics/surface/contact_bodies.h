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

/// Returns whether an object's contact is decided by its mesh, which is so if it is rigid.  A soft
/// object has a compliance for each leaf, so its leaves decide.
bool IsFeltByMesh(const PlacedTree& object);

/// A body as contact sees it: triangles with a tree over them, enlarged by a radius [m].  The
/// radius is 0 except for a spherical tool, whose mesh is a single point.
struct ContactBody {
  explicit ContactBody(ContactMesh m, double rounding = 0.0)
      : mesh(std::move(m)), tree(mesh), radius(rounding) {}
  ContactBody(ContactMesh m, HullTree t) : mesh(std::move(m)), tree(std::move(t)) {}

  ContactMesh mesh;
  HullTree tree;
  double radius = 0.0;
  /// For a tool: the part that solids touch as a mesh while the tool cuts, which is all but the
  /// head of a bur or edge.  Empty if the tool is all head.
  std::optional<HullTree::Node> shank = tree.root();
  /// For each triangle of an object, the index of the nearest leaf of the forest, which
  /// gives the triangle's material.
  std::vector<std::int32_t> leaf;
};

/// Makes a body in W of each object that is felt by its mesh.  Throws Error if such an
/// object has no mesh.
std::vector<ContactBody> MakeBodies(std::span<const PlacedTree> objects);

/// Returns whether a point of W, which lies on no surface, is inside a body: the winding number of
/// the body's mesh there exceeds one half, which also decides for an open mesh.  Not real-time.
bool Hold(std::span<const ContactBody> bodies, const Vec3& p_W);

/// Makes the body of a tool about its reference point: its mesh or, if the tool is a single ball,
/// the centre with its radius.  Throws Error if any other tool has no mesh.
/// `cutting`: of a bur or an edge; otherwise null.
std::unique_ptr<const ContactBody> MakeToolBody(const TriangleMesh* mesh, const SphereTree& tree,
                                                const Vec3& reference,
                                                const Cutting* cutting = nullptr);

}  // namespace palpate
