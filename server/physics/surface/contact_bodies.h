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
bool TouchesByMesh(const PlacedTree& object);

/// A body's geometry as contact sees it: triangles with a tree over them, in the body's frame.
struct ContactShape {
  explicit ContactShape(ContactMesh m) : mesh(std::move(m)), tree(mesh) {}
  ContactShape(ContactMesh m, HullTree t) : mesh(std::move(m)), tree(std::move(t)) {}

  ContactMesh mesh;
  HullTree tree;
  /// For each triangle of an object, the index of the nearest leaf of the object's tree, which
  /// gives the triangle's material.
  std::vector<std::int32_t> leaf;
};

/// Returns whether a point lies over a triangle, or next to it by no more than `reach` [m].
bool IsOver(const Vec3* corners, const Vec3& p, double reach);

/// Returns one of the shape's triangles over which a point p of its frame lies, no farther than
/// `apart` [m] on either side, whose normal differs from n, or -n, by no more than `turned` [rad].
/// None for a shape of blocks.  Real-time.
std::optional<std::uint32_t> FaceAt(const ContactShape& shape, const Vec3& p, const Vec3& n,
                                    double apart, double turned);
/// Returns whether there is one.
inline bool HasFaceAt(const ContactShape& shape, const Vec3& p, const Vec3& n, double apart,
                      double turned) {
  return FaceAt(shape, p, n, apart, turned).has_value();
}

/// Where a frame lies in another: a Pose whose rotation is a matrix.
struct Placement {
  Vec3 operator*(const Vec3& x) const { return R * x + p; }
  Placement Inverse() const { return {-(R.transpose() * p), R.transpose()}; }
  Placement operator*(const Placement& other) const { return {*this * other.p, R * other.R}; }
  /// For kernels: p, then the columns of R.
  const double* data() const { return reinterpret_cast<const double*>(this); }

  Vec3 p;
  Mat3 R;
};
static_assert(sizeof(Placement) == 12 * sizeof(double), "data() reads p and R as one array");
inline Placement PlacementOf(const Pose& X) {
  return {X.p, X.q.toRotationMatrix()};
}

/// One of the bodies that a tool can touch, as contact sees it.  Those with the same mesh share its
/// shape, which has the frame S.
struct ContactBody {
  std::shared_ptr<const ContactShape> shape;
  Placement X_BS;
  std::int32_t first_leaf = 0;  ///< in the forest
  std::int32_t frame = 0;       ///< number of B: bodies of one frame stand still to each other
  std::int32_t tool = -1;       ///< number of the member that it is, or negative (PlacedTree)
  bool is_body = false;         ///< whether that is a free body
};

/// A body A that moves against them, as contact sees it, about its reference point: its shape
/// enlarged by a radius [m], which is 0 except for a ball, whose mesh is a single point.
struct MovingBody : ContactShape {
  using ContactShape::ContactShape;

  double radius = 0.0;
  /// The part that solids touch as a mesh while the tool cuts, which is all but the head of a bur
  /// or edge.  Empty if the tool is all head.
  std::optional<HullTree::Node> shank = tree.root();
};

/// Returns the number of frames of bodies: one more than the greatest number.
std::size_t CountFrames(std::span<const ContactBody> bodies);

/// Makes a body of each object that is touched by its mesh.  Throws Error if such an object has no
/// mesh.
std::vector<ContactBody> MakeBodies(std::span<const PlacedTree> objects);

/// Returns whether a point of frame S, which lies on no surface, is inside a shape: the winding
/// number of its mesh there exceeds one half, which also decides for an open mesh.
bool Holds(const ContactShape& shape, const Vec3& p_S);

/// Returns whether a point of frame B is so inside a body that is no tool.  Not real-time.
bool Hold(std::span<const ContactBody> bodies, const Vec3& p_B);

/// Makes the body of a tool about its reference point: its mesh or, if the tool is a single ball,
/// the centre with its radius.  Throws Error if any other tool has no mesh.
/// `cutting`: of a bur or an edge; otherwise null.
std::unique_ptr<const MovingBody> MakeMovingBody(const TriangleMesh* mesh, const SphereTree& tree,
                                                 const Vec3& reference,
                                                 const Cutting* cutting = nullptr);

}  // namespace palpate
