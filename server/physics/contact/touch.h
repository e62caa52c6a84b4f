#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "common/math/pose.h"
#include "server/physics/limits.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/surface/contact_bodies.h"
#include "server/physics/surface/separating_plane.h"
#include "server/physics/surface/separation_front.h"
#include "server/physics/surface/solid_bodies.h"
#include "server/physics/surface/triangle_distance.h"

namespace palpate {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The straight motion of A in B in one sub-step; a candidate until it is accepted.
struct Motion {
  RelativePose from, to;
  Vec3 v, phi;  ///< [m], [rad]
  bool moves;

  explicit Motion(const RelativePose& start, const Vec3& step_v = Vec3::Zero(),
                  const Vec3& step_phi = Vec3::Zero())
      : from(start),
        to(start),
        v(step_v),
        phi(step_phi),
        moves(!v.isZero(0.0) || !phi.isZero(0.0)) {
    if (moves) to = from.Moved(v, phi);
  }
};

/// Nodes of two trees, A's and that of a body of B; each is a triangle or a patch.
struct NodesOfPair {
  HullTree::Node a, b;
  const ContactShape* shape;  ///< of the body of B
  std::int32_t number;        ///< of that body
  std::int32_t placed;        ///< index in B of the body in whose frame S it is: a block's solid
  bool AreTriangles() const { return HullTree::IsLeaf(a) && HullTree::IsLeaf(b); }
  bool AreOfBlock() const { return number != placed; }
};

/// The corners of two triangles, in B [m].
struct Corners {
  Vec3 a[3], b[3];
};

/// A body A, and the bodies B that contact keeps it apart from.  Those of B stand still to each
/// other, so one frame holds them all: whatever has no other frame in its name is in B.  Heights
/// are along n, from B to A.
struct MeshPair {
  const MovingBody& a;
  std::span<const ContactBody> b;  ///< with those of other frames, which are not of this pair
  std::int32_t frame = 0;          ///< number of B
  SolidBodies* solids = nullptr;   ///< bodies of blocks in B; null if there are none
  bool cuts = true;  ///< true for a bur or an edge that cuts: solids touch only its shank
  limits::mesh::Margins margins{};
  const Kernels* kernels = &ActiveKernels();

  double Low(HullTree::Node node, const Vec3& n, const RelativePose& at) const {
    return n.dot(at.p) - a.tree.Highest(node, -(at.R.transpose() * n), *kernels) - a.radius;
  }
  double High(const NodesOfPair& nodes, const Vec3& n) const {
    const Placement& X_BS = FrameOf(nodes);
    return n.dot(X_BS.p) + nodes.shape->tree.Highest(nodes.b, X_BS.R.transpose() * n, *kernels);
  }
  /// The pose X_BS of a body of B.
  const Placement& FrameOf(const NodesOfPair& nodes) const {
    return b[static_cast<std::size_t>(nodes.placed)].X_BS;
  }
  NodesOfPair NodesOf(const SeparationFront::Pair& pair) const {
    return NodesOf(pair.a, pair.b, pair.body);
  }
  NodesOfPair NodesOf(HullTree::Node of_a, HullTree::Node of_b, std::int32_t number) const {
    const auto body = static_cast<std::size_t>(number);
    if (body < b.size()) {
      return {of_a, of_b, b[body].shape.get(), number, number};
    }
    const BlockBody& block = solids->Body(number);
    return {of_a, of_b, &block.shape, number, block.of.solid};
  }
  PatchPair PatchesOf(const NodesOfPair& nodes) const {
    return {a.tree.HullOf(nodes.a), nodes.shape->tree.HullOf(nodes.b), a.radius};
  }
  /// For two triangles: the normal of B's, out of a solid.
  Vec3 OutwardOf(const NodesOfPair& triangles) const {
    const std::uint32_t t = HullTree::TriangleOf(triangles.b);
    return FrameOf(triangles).R * triangles.shape->mesh.triangles()[t].normal;
  }
  /// The part of A that solids can touch; empty if they touch none of it.
  std::optional<HullTree::Node> ForSolids() const {
    return cuts ? a.shank : std::optional(a.tree.root());
  }
  /// How far A's node lies above B's along n [m]; negative if n does not separate them.
  double Gap(const NodesOfPair& nodes, const Vec3& n, const RelativePose& at) const {
    return Low(nodes.a, n, at) - High(nodes, n);
  }
  Corners CornersAt(const NodesOfPair& triangles, const RelativePose& at) const;
  /// For two triangles.
  NearestPoints NearestAt(const NodesOfPair& triangles, const RelativePose& at) const {
    const Corners corners = CornersAt(triangles, at);
    return NearestOfTriangles(corners.a, corners.b, *kernels);
  }
  bool IsBall() const { return a.radius > 0.0; }
  /// The lever of A's farthest point [m].
  double Reach() const { return a.mesh.reach() + a.radius; }
};

/// A plane between two triangles, and the body that it moves with.
struct ContactPlane {
  enum class Of : std::uint8_t { kNone, kB, kA, kEdges } of = Of::kNone;
  Vec3 n = Vec3::Zero();  ///< unit, from B to A; in B, but for kA in A's frame; for
                          ///< kEdges B's edge, not unit [m]
  std::uint8_t edge_a = 0, edge_b = 0;
  double sign = 1.0;  ///< kEdges: the normal is sign * (A's edge x B's edge), normalised
};

/// A pair of triangles that may touch, as they lie at the beginning of the sub-step.
struct Touch {
  NodesOfPair nodes;
  NearestPoints nearest;   ///< in B
  Vec3 u = Vec3::UnitZ();  ///< unit direction between them, from B to A
  double distance;         ///< the gap along u [m]: negative where they intersect
  bool in_cone;            ///< no neighbouring triangle is nearer
  /// Whether a plane is measured by the gap that it leaves itself, and not by `distance`: outside
  /// the cones the plane is a neighbour's, which leaves less.  If it had to leave the distance, a
  /// tool could not slide along a face over the next triangle of the same face.  A ball keeps
  /// delta from every triangle.
  bool by_plane;
  /// Whether the tool is in a block's triangle, or just behind it.  One that it is behind hinders
  /// no motion: a tool comes there only through others, or where a solid's new surface stands out
  /// into it.  Behind one that it is in, it may go no deeper.
  bool is_behind = false;
  /// Where friction acts: whether the tool lies on the body's face, which is the plane.
  bool is_flush = false;
  ContactPlane plane;  ///< that its rows use; kNone if it has no rows
  /// Whether its rows have been mended: once at most in a sub-step.  Otherwise two planes, or two
  /// directions, could alternate.
  bool is_mended = false;
  int row[3] = {-1, -1, -1};  ///< for each corner (kEdges: only the first is used); -1: none

  /// Returns the gap that a plane must leave after a sub-step if it leaves `before` [m] at its
  /// beginning: so much that the pair comes no nearer than h, or than it is (README.md).
  double LeastAfter(const limits::mesh::Margins& margins, double before) const {
    return margins.LeastAfter(by_plane ? before : distance);
  }
  /// Returns whether a plane that leaves these gaps [m] at both ends of a sub-step proves that the
  /// pair was apart.
  bool Proves(const limits::mesh::Margins& margins, double before, double after) const {
    if (is_behind) return distance > 0.0 || after >= before - limits::mesh::kRounding;
    const double least = by_plane ? limits::mesh::kRounding : margins.LeastBefore(distance);
    return before >= least && after >= LeastAfter(margins, before);
  }
};

/// Returns the unit direction between two nearest points, from B to A.  It is that of the
/// features: a face's normal, or the common normal of two edges.  Across the points themselves it
/// would err by their rounding over their distance, 5e-5 rad at a micrometre.
Vec3 DirectionAt(const MeshPair& meshes, const NodesOfPair& triangles, const NearestPoints& nearest,
                 const RelativePose& at);

/// Returns the touch of two triangles at a pose.  If they intersect, u is the direction
/// of the least depth.
Touch TouchAt(const MeshPair& meshes, const NodesOfPair& triangles, const RelativePose& at);

/// Returns a plane's normal in B at a pose.
Vec3 NormalAt(const MeshPair& meshes, const Touch& touch, const ContactPlane& plane,
              const RelativePose& at);
/// Returns the gap of a pair of nodes, the touch's own or others, along a plane of the touch
/// at a pose [m].
double GapAt(const MeshPair& meshes, const NodesOfPair& nodes, const Touch& touch,
             const ContactPlane& plane, const RelativePose& at);

/// Returns whether features of two triangles can touch along n, from B to A: it lies in the
/// normal cones of both; if not, a neighbour is nearer.
bool ConesHold(const MeshPair& meshes, const NodesOfPair& triangles, Feature of_a, Feature of_b,
               const Vec3& n, const RelativePose& at);
/// ConesHold for the features at nearest points, and the direction u between them.
inline bool InCone(const MeshPair& meshes, const NodesOfPair& triangles,
                   const NearestPoints& nearest, const Vec3& u, const RelativePose& at) {
  return ConesHold(meshes, triangles, nearest.of_p, nearest.of_q, u, at);
}

/// For two triangles: ContactMesh::SmoothNormal of the body where it is touched along n.
Vec3 SmoothNormal(const MeshPair& meshes, const NodesOfPair& triangles,
                  const NearestPoints& nearest, const Vec3& n);

/// Calls visit(normal) for each face of a mesh that meets at a feature of one of its triangles.
template <class Visit>
void ForEachFaceAt(const ContactMesh& mesh, HullTree::Node triangle, Feature of, Visit visit) {
  const ContactMesh::Triangle& t = mesh.triangles()[HullTree::TriangleOf(triangle)];
  if (of.kind == Feature::kFace) return visit(t.normal);
  const auto faces = of.kind == Feature::kEdge ? mesh.FacesAtEdge(t.edge[of.index])
                                               : mesh.FacesAtVertex(t.vertex[of.index]);
  for (const std::uint32_t face : faces) visit(mesh.triangles()[face].normal);
}

/// Calls visit(plane) for each face of either mesh that meets at the nearest points, with its
/// normal turned to point from B to A at the beginning of the motion.
template <class Visit>
void ForEachFace(const MeshPair& meshes, const NodesOfPair& triangles, const NearestPoints& nearest,
                 const RelativePose& from, Visit visit) {
  const Vec3 away = nearest.p - nearest.q;
  const auto give = [&](ContactPlane::Of of, const Vec3& n, const Vec3& n_B) {
    if (n == Vec3::Zero()) return;
    visit(ContactPlane{of, n_B.dot(away) < 0.0 ? Vec3(-n) : n});
  };
  const Mat3& R_BS = meshes.FrameOf(triangles).R;
  ForEachFaceAt(triangles.shape->mesh, triangles.b, nearest.of_q, [&](const Vec3& n) {
    const Vec3 n_B = R_BS * n;
    give(ContactPlane::Of::kB, n_B, n_B);
  });
  ForEachFaceAt(meshes.a.mesh, triangles.a, nearest.of_p,
                [&](const Vec3& n) { give(ContactPlane::Of::kA, n, from.R * n); });
}

/// Returns how much nearer a pair may come between the ends of a motion than at either end
/// [m].  A plane of edges turns while the contact moves; this takes at most a quarter of
/// the product of both.
/// @param n_old, n_new  the plane's normals at both ends
double RotationLoss(const Touch& touch, const ContactPlane& plane, const Vec3& n_old,
                    const Vec3& n_new, const Motion& motion);

/// Up to eight planes that may separate two triangles throughout a motion, measured together.
class TriedPlanes {
 public:
  TriedPlanes(const MeshPair& meshes, const NodesOfPair& triangles, const Motion& motion)
      : meshes_(meshes),
        motion_(motion),
        pair_{meshes.a.tree.HullOf(triangles.a).leaf->data(),
              triangles.shape->tree.HullOf(triangles.b).leaf->data(),
              motion.from.data(),
              motion.to.data(),
              meshes.FrameOf(triangles).data(),
              meshes.a.radius} {}

  /// @param touch  that the plane belongs to: that of these triangles, or a neighbour's
  void Add(const Touch& touch, const ContactPlane& plane) {
    const bool stays = plane.of == ContactPlane::Of::kB;
    Add(touch, plane, stays ? plane.n : NormalAt(meshes_, touch, plane, motion_.from),
        stays ? plane.n : NormalAt(meshes_, touch, plane, motion_.to));
  }
  bool IsFull() const { return count_ == kMost; }
  /// Measures the planes, and calls takes(i) for one after the other until it returns true; returns
  /// whether one did.  Forgets them all.
  template <class Takes>
  bool Find(Takes takes) {
    const int count = std::exchange(count_, 0);
    if (count > 0) meshes_.kernels->find_gaps(pair_, gaps_);
    for (int i = 0; i < count; ++i) {
      if (takes(i)) return true;
    }
    return false;
  }
  const ContactPlane& plane(int i) const { return planes_[i]; }
  double before(int i) const { return gaps_.gap[0][i]; }
  double after(int i) const { return gaps_.gap[1][i]; }
  Vec3 n_before(int i) const { return Normal(0, i); }
  Vec3 n_after(int i) const { return Normal(1, i); }
  double Loss(int i) const {
    return RotationLoss(*of_[i], planes_[i], n_before(i), n_after(i), motion_);
  }

 private:
  static constexpr int kMost = 8;
  void Add(const Touch& touch, const ContactPlane& plane, const Vec3& before, const Vec3& after);
  Vec3 Normal(int end, int i) const {
    return {gaps_.n[end][0][i], gaps_.n[end][1][i], gaps_.n[end][2][i]};
  }

  const MeshPair& meshes_;
  const Motion& motion_;
  TrianglePair pair_;
  EightGaps gaps_;
  ContactPlane planes_[kMost];
  const Touch* of_[kMost];
  int count_ = 0;
};

/// Returns the plane that a touch uses for its rows after a candidate in which no plane separates
/// it.
ContactPlane ChoosePlane(const MeshPair& meshes, const Touch& touch, const Motion& candidate);

/// Of the planes that separate a touch at the beginning, returns the one with the largest gap at
/// the end of the candidate; kNone if there is no other plane.
/// @param nearest, u  of the triangles at the end.
ContactPlane OtherPlane(const MeshPair& meshes, const Touch& touch, const NearestPoints& nearest,
                        const Vec3& u, const Motion& candidate);

}  // namespace palpate
