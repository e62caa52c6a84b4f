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
#include "server/physics/surface/felt_solids.h"
#include "server/physics/surface/separating_plane.h"
#include "server/physics/surface/separation_front.h"
#include "server/physics/surface/triangle_distance.h"

namespace palpate {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The straight motion of the tool in one sub-step; a trial until it is accepted.
struct Motion {
  ToolPose from, to;
  Vec3 v, phi;  ///< [m], [rad]
  bool moves;

  explicit Motion(const ToolPose& start, const Vec3& step_v = Vec3::Zero(),
                  const Vec3& step_phi = Vec3::Zero())
      : from(start),
        to(start),
        v(step_v),
        phi(step_phi),
        moves(!v.isZero(0.0) || !phi.isZero(0.0)) {
    if (moves) to = from.Moved(v, phi);
  }
};

/// Nodes of two trees, the tool's and a body's; each is a triangle or a patch.
struct NodesOfPair {
  HullTree::Node tool, object;
  const ContactShape* shape;  ///< of the body
  std::int32_t number;        ///< number of the body
  std::int32_t placed;        ///< index of the scene's body in whose frame B it is: a block's solid
  bool AreTriangles() const { return HullTree::IsLeaf(tool) && HullTree::IsLeaf(object); }
  bool AreOfBlock() const { return number != placed; }
};

/// The corners of two triangles, in W [m].
struct Corners {
  Vec3 tool[3], object[3];
};

/// A tool, and the bodies that contact keeps it apart from.  Heights are along n, from body
/// to tool, in W.
struct ToolAndBodies {
  const ToolBody& tool;
  std::span<const ContactBody> bodies;
  FeltSolids* felt = nullptr;  ///< bodies of blocks; null if there are none
  bool cuts = true;            ///< true for a bur or an edge that cuts: solids touch only its shank
  limits::mesh::Margins margins{};
  const Kernels* kernels = &ActiveKernels();

  double Low(HullTree::Node node, const Vec3& n, const ToolPose& at) const {
    return n.dot(at.p) - tool.tree.Highest(node, -(at.R.transpose() * n), *kernels) - tool.radius;
  }
  double High(const NodesOfPair& nodes, const Vec3& n) const {
    const Placement& X_WB = FrameOf(nodes);
    return n.dot(X_WB.p) +
           nodes.shape->tree.Highest(nodes.object, X_WB.R.transpose() * n, *kernels);
  }
  /// The pose X_WB of a body.
  const Placement& FrameOf(const NodesOfPair& nodes) const {
    return bodies[static_cast<std::size_t>(nodes.placed)].X_WB;
  }
  NodesOfPair NodesOf(const SeparationFront::Pair& pair) const {
    return NodesOf(pair.tool, pair.object, pair.body);
  }
  NodesOfPair NodesOf(HullTree::Node of_tool, HullTree::Node of_object, std::int32_t number) const {
    const auto body = static_cast<std::size_t>(number);
    if (body < bodies.size()) {
      return {of_tool, of_object, bodies[body].shape.get(), number, number};
    }
    const BlockBody& block = felt->Body(number);
    return {of_tool, of_object, &block.shape, number, block.of.solid};
  }
  PatchPair PatchesOf(const NodesOfPair& nodes) const {
    return {tool.tree.HullOf(nodes.tool), nodes.shape->tree.HullOf(nodes.object), tool.radius};
  }
  /// For two triangles: the normal of the body's, out of a solid.
  Vec3 OutwardOf(const NodesOfPair& triangles) const {
    const std::uint32_t t = HullTree::TriangleOf(triangles.object);
    return FrameOf(triangles).R * triangles.shape->mesh.triangles()[t].normal;
  }
  /// The part of the tool that solids can touch; empty if they touch none of it.
  std::optional<HullTree::Node> ForSolids() const {
    return cuts ? tool.shank : std::optional(tool.tree.root());
  }
  /// How far the tool's node lies above the body's along n [m]; negative if n
  /// does not separate them.
  double Gap(const NodesOfPair& nodes, const Vec3& n, const ToolPose& at) const {
    return Low(nodes.tool, n, at) - High(nodes, n);
  }
  Corners CornersAt(const NodesOfPair& triangles, const ToolPose& at) const;
  /// For two triangles.
  NearestPoints NearestAt(const NodesOfPair& triangles, const ToolPose& at) const {
    const Corners corners = CornersAt(triangles, at);
    return NearestOfTriangles(corners.tool, corners.object, *kernels);
  }
  bool IsBall() const { return tool.radius > 0.0; }
};

/// A plane between two triangles, and the body that it moves with.
struct ContactPlane {
  enum class Of : std::uint8_t { kNone, kObject, kTool, kEdges } of = Of::kNone;
  Vec3 n = Vec3::Zero();  ///< unit, from object to tool; in W, but for kTool in the tool's frame;
                          ///< for kEdges the object's edge in W, not unit [m]
  std::uint8_t tool_edge = 0, object_edge = 0;
  double sign = 1.0;  ///< kEdges: the normal is sign * (tool's edge x object's edge), normalised
};

/// A pair of triangles that may touch, as they lie at the beginning of the sub-step.
struct Touch {
  NodesOfPair nodes;
  NearestPoints nearest;   ///< in W
  Vec3 u = Vec3::UnitZ();  ///< unit direction between them, from object to tool
  double distance;         ///< the gap along u [m]: negative where they intersect
  bool in_cone;            ///< no neighbouring triangle is nearer
  /// Whether a plane is measured by the gap that it leaves itself, and not by `distance`: outside
  /// the cones the plane is a neighbour's, which leaves less.  If it had to leave the distance, a
  /// tool could not slide along a face over the next triangle of the same face.  A ball keeps
  /// delta from every triangle.
  bool by_plane;
  /// Whether the tool is in a block's triangle, or just behind it.  One that it is behind hinders
  /// no way: a tool comes there only through others, or where a solid's new surface stands out into
  /// it.  Behind one that it is in, it may go no deeper.
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

/// Returns the unit direction between two nearest points, from object to tool.  It is that of the
/// features: a face's normal, or the common normal of two edges.  Across the points themselves it
/// would err by their rounding over their distance, 5e-5 rad at a micrometre.
Vec3 DirectionAt(const ToolAndBodies& meshes, const NodesOfPair& triangles,
                 const NearestPoints& nearest, const ToolPose& at);

/// Returns the touch of two triangles at a pose.  If they intersect, u is the direction
/// of the least depth.
Touch TouchAt(const ToolAndBodies& meshes, const NodesOfPair& triangles, const ToolPose& at);

/// Returns a plane's normal in W at a pose.
Vec3 NormalAt(const ToolAndBodies& meshes, const Touch& touch, const ContactPlane& plane,
              const ToolPose& at);
/// Returns the gap of a pair of nodes, the touch's own or others, along a plane of the touch
/// at a pose [m].
double GapAt(const ToolAndBodies& meshes, const NodesOfPair& nodes, const Touch& touch,
             const ContactPlane& plane, const ToolPose& at);

/// Returns whether features of two triangles can touch along n, from object to tool: it lies in the
/// normal cones of both; if not, a neighbour is nearer.
bool ConesHold(const ToolAndBodies& meshes, const NodesOfPair& triangles, Feature of_tool,
               Feature of_object, const Vec3& n, const ToolPose& at);
/// ConesHold for the features at nearest points, and the direction u between them.
inline bool InCone(const ToolAndBodies& meshes, const NodesOfPair& triangles,
                   const NearestPoints& nearest, const Vec3& u, const ToolPose& at) {
  return ConesHold(meshes, triangles, nearest.of_p, nearest.of_q, u, at);
}

/// For two triangles: ContactMesh::SmoothNormal of the body where it is touched along n.
Vec3 SmoothNormal(const ToolAndBodies& meshes, const NodesOfPair& triangles,
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
/// normal turned to point from object to tool at the beginning of the motion.
template <class Visit>
void ForEachFace(const ToolAndBodies& meshes, const NodesOfPair& triangles,
                 const NearestPoints& nearest, const ToolPose& from, Visit visit) {
  const Vec3 away = nearest.p - nearest.q;
  const auto give = [&](ContactPlane::Of of, const Vec3& n, const Vec3& n_W) {
    if (n == Vec3::Zero()) return;
    visit(ContactPlane{of, n_W.dot(away) < 0.0 ? Vec3(-n) : n});
  };
  const Mat3& R_WB = meshes.FrameOf(triangles).R;
  ForEachFaceAt(triangles.shape->mesh, triangles.object, nearest.of_q, [&](const Vec3& n) {
    const Vec3 n_W = R_WB * n;
    give(ContactPlane::Of::kObject, n_W, n_W);
  });
  ForEachFaceAt(meshes.tool.mesh, triangles.tool, nearest.of_p,
                [&](const Vec3& n) { give(ContactPlane::Of::kTool, n, from.R * n); });
}

/// Returns how much nearer a pair may come between the ends of a motion than at either end
/// [m].  A plane of edges turns while the contact moves; this takes at most a quarter of
/// the product of both.
/// @param n_old, n_new  the plane's normals at both ends
double TurnLoss(const Touch& touch, const ContactPlane& plane, const Vec3& n_old, const Vec3& n_new,
                const Motion& motion);

/// Up to eight planes that may separate two triangles throughout a motion, measured together.
class TriedPlanes {
 public:
  TriedPlanes(const ToolAndBodies& meshes, const NodesOfPair& triangles, const Motion& motion)
      : meshes_(meshes),
        motion_(motion),
        pair_{meshes.tool.tree.HullOf(triangles.tool).leaf->data(),
              triangles.shape->tree.HullOf(triangles.object).leaf->data(),
              motion.from.data(),
              motion.to.data(),
              meshes.FrameOf(triangles).data(),
              meshes.tool.radius} {}

  /// @param touch  that the plane belongs to: that of these triangles, or a neighbour's
  void Add(const Touch& touch, const ContactPlane& plane) {
    const bool stays = plane.of == ContactPlane::Of::kObject;
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
    return TurnLoss(*of_[i], planes_[i], n_before(i), n_after(i), motion_);
  }

 private:
  static constexpr int kMost = 8;
  void Add(const Touch& touch, const ContactPlane& plane, const Vec3& before, const Vec3& after);
  Vec3 Normal(int end, int i) const {
    return {gaps_.n[end][0][i], gaps_.n[end][1][i], gaps_.n[end][2][i]};
  }

  const ToolAndBodies& meshes_;
  const Motion& motion_;
  TrianglePair pair_;
  EightGaps gaps_;
  ContactPlane planes_[kMost];
  const Touch* of_[kMost];
  int count_ = 0;
};

/// Returns the plane that a touch uses for its rows after a trial in which no plane separates it.
ContactPlane ChoosePlane(const ToolAndBodies& meshes, const Touch& touch, const Motion& trial);

/// Of the planes that separate a touch at the beginning, returns the one with the largest gap at
/// the end of the trial; kNone if there is no other plane.
/// @param nearest, u  of the triangles at the end.
ContactPlane OtherPlane(const ToolAndBodies& meshes, const Touch& touch,
                        const NearestPoints& nearest, const Vec3& u, const Motion& trial);

}  // namespace palpate
