#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "common/math/pose.h"
#include "server/physics/limits.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/surface/contact_bodies.h"
#include "server/physics/surface/felt_solids.h"
#include "server/physics/surface/separation_front.h"
#include "server/physics/surface/tool_pose.h"
#include "server/physics/surface/triangle_distance.h"

namespace palpate {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The straight motion of the tool in one sub-step; a trial, until it is taken.
struct Motion {
  ToolPose from, to;
  Vec3 v = Vec3::Zero(), phi = Vec3::Zero();  ///< [m], [rad]
  bool moves = false;

  explicit Motion(const ToolPose& start) : from(start), to(start) {}
  Motion(const ToolPose& start, const Vec3& step_v, const Vec3& step_phi)
      : from(start),
        to(start),
        v(step_v),
        phi(step_phi),
        moves(step_v != Vec3::Zero() || step_phi != Vec3::Zero()) {
    if (moves) to = from.Moved(v, phi);
  }
};

/// Nodes of two trees: triangles or patches, the tool's and a body's.
struct NodesOfPair {
  HullTree::Node tool, object;
  const ContactBody* body;
  std::int32_t number;  ///< of the body
  bool AreTriangles() const { return HullTree::IsLeaf(tool) && HullTree::IsLeaf(object); }
  /// Of two triangles: ContactMesh::SmoothNormal of the body's, where it is touched along n.
  Vec3 SmoothNormal(const NearestPoints& nearest, const Vec3& n) const {
    return body->mesh.SmoothNormal(HullTree::TriangleOf(object), nearest.q, n);
  }
};

/// Corners of two triangles in W [m].
struct Corners {
  Vec3 tool[3], object[3];
};

/// What contact keeps apart: a tool from each of the bodies.  Heights are along n, from body to
/// tool, in W.
struct ToolAndBodies {
  const ContactBody& tool;              ///< about its reference point
  std::span<const ContactBody> bodies;  ///< in W
  FeltSolids* felt = nullptr;  ///< of what bodies of blocks stand for; null where there are none
  bool cuts = true;            ///< a bur or an edge, which solids are felt by its shank
  limits::mesh::Margins margins{};
  const Kernels* kernels = &ActiveKernels();

  double Low(HullTree::Node node, const Vec3& n, const ToolPose& at) const {
    return n.dot(at.p) - tool.tree.Highest(node, -(at.R.transpose() * n), *kernels) - tool.radius;
  }
  double High(const NodesOfPair& nodes, const Vec3& n) const {
    return nodes.body->tree.Highest(nodes.object, n, *kernels);
  }
  NodesOfPair NodesOf(const SeparationFront::Pair& pair) const {
    const auto number = static_cast<std::size_t>(pair.body);
    return {pair.tool, pair.object,
            number < bodies.size() ? &bodies[number] : &felt->Body(pair.body), pair.body};
  }
  /// What of the tool solids are felt by; none where nothing is.
  std::optional<HullTree::Node> ForSolids() const {
    return cuts ? tool.shank : std::optional(tool.tree.root());
  }
  /// How far the one lies above the other [m]; negative where n does not separate them.
  double Gap(const NodesOfPair& nodes, const Vec3& n, const ToolPose& at) const {
    return Low(nodes.tool, n, at) - High(nodes, n);
  }
  Corners CornersAt(const NodesOfPair& triangles, const ToolPose& at) const;
  /// Of two triangles.
  NearestPoints NearestAt(const NodesOfPair& triangles, const ToolPose& at) const {
    const Corners corners = CornersAt(triangles, at);
    return NearestOfTriangles(corners.tool, corners.object, *kernels);
  }
  bool IsBall() const { return tool.radius > 0.0; }
};

/// A plane between two triangles, and what it moves with.
struct ContactPlane {
  enum class Of : std::uint8_t { kNone, kObject, kTool, kEdges } of = Of::kNone;
  Vec3 n = Vec3::Zero();  ///< unit, from object to tool; in W, of kTool in the tool's frame
  std::uint8_t tool_edge = 0, object_edge = 0;
  double sign = 1.0;  ///< kEdges: n = sign * (tool's edge x object's edge), normalised
};

/// A pair of triangles that may touch: how they lie where the sub-step begins.
struct Touch {
  NodesOfPair nodes;
  NearestPoints nearest;   ///< in W
  Vec3 u = Vec3::UnitZ();  ///< unit direction between them, from object to tool
  double distance;         ///< the gap along u [m]: negative where they intersect
  bool in_cone;            ///< no neighbour is nearer
  ContactPlane plane;      ///< of its rows; kNone where it has none
  /// Once in a sub-step: two planes, or two directions, could be taken for each other in turn.
  bool retracted = false, relinearised = false;
  int row[3] = {-1, -1, -1};  ///< of the corners, or the one row of kEdges; -1: none
};

/// Two triangles as they lie at a pose.  Where they intersect, u is the direction of the least
/// depth.
Touch TouchAt(const ToolAndBodies& meshes, const NodesOfPair& triangles, const ToolPose& at);

/// A plane's normal in W, at a pose.
Vec3 NormalAt(const ToolAndBodies& meshes, const Touch& touch, const ContactPlane& plane,
              const ToolPose& at);
/// Gap of nodes, the touch's own or others, along a plane of the touch at a pose [m].
double GapAt(const ToolAndBodies& meshes, const NodesOfPair& nodes, const Touch& touch,
             const ContactPlane& plane, const ToolPose& at);

/// Whether the direction u between two nearest points lies in the normal cones of both features:
/// else a neighbour is nearer.
bool InCone(const ToolAndBodies& meshes, const NodesOfPair& triangles, const NearestPoints& nearest,
            const Vec3& u, const ToolPose& at);

/// Calls visit(plane) for the faces that meet at the nearest points, of either mesh, turned to look
/// from object to tool at the motion's beginning.
template <class Visit>
void ForEachFace(const ToolAndBodies& meshes, const NodesOfPair& triangles,
                 const NearestPoints& nearest, const ToolPose& from, Visit visit) {
  const auto each = [&](const ContactMesh& mesh, HullTree::Node node, Feature of, auto use) {
    const std::uint32_t own = HullTree::TriangleOf(node);
    const ContactMesh::Triangle& t = mesh.triangles()[own];
    if (of.kind == Feature::kFace) {
      use(t.normal);
    } else {
      const auto faces = of.kind == Feature::kEdge ? mesh.FacesAtEdge(t.edge[of.index])
                                                   : mesh.FacesAtVertex(t.vertex[of.index]);
      for (std::uint32_t face : faces) use(mesh.triangles()[face].normal);
    }
  };
  const Vec3 away = nearest.p - nearest.q;
  const auto give = [&](ContactPlane::Of of, const Vec3& n, const Vec3& n_W) {
    if (n == Vec3::Zero()) return;
    visit(ContactPlane{of, n_W.dot(away) < 0.0 ? Vec3(-n) : n});
  };
  each(triangles.body->mesh, triangles.object, nearest.of_q,
       [&](const Vec3& n) { give(ContactPlane::Of::kObject, n, n); });
  each(meshes.tool.mesh, triangles.tool, nearest.of_p,
       [&](const Vec3& n) { give(ContactPlane::Of::kTool, n, from.R * n); });
}

/// The plane that a touch gives rows by, for a trial that no plane allows.
ContactPlane ChoosePlane(const ToolAndBodies& meshes, const Touch& touch, const Motion& trial);
/// The plane that a touch has most room along at the trial's end, of those that keep it apart at
/// the beginning too; none where there is no other one.
/// @param nearest, u  of the triangles at the end.
ContactPlane OtherPlane(const ToolAndBodies& meshes, const Touch& touch,
                        const NearestPoints& nearest, const Vec3& u, const Motion& trial);

/// What a pair may come nearer by between the ends of a motion [m]: a plane of edges turns while
/// the contact moves, and the gap in between is less by a quarter of the one times the other at
/// most.
double TurnLoss(const ToolAndBodies& meshes, const Touch& touch, const ContactPlane& plane,
                const Motion& motion);

}  // namespace palpate
