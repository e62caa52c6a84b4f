#include "server/physics/contact/touch.h"

#include <algorithm>
#include <cmath>

#include "server/physics/limits.h"

namespace palpate {
namespace {

using namespace limits::mesh;

// Functions that every query calls are marked gnu::flatten: depending on what else is in the file,
// GCC would leave Eigen's products in them as calls, with which a long step takes 5 % longer.

Vec3 EdgeOf(const ContactMesh& mesh, HullTree::Node node, int i) {
  const std::uint32_t t = HullTree::TriangleOf(node);
  return mesh.Corner(t, (i + 1) % 3) - mesh.Corner(t, i);
}

/// Finds the direction of least penetration of two triangles.
void FindLeastDepth(const MeshPair& meshes, const RelativePose& at, Touch& touch) {
  const Corners corners = meshes.CornersAt(touch.nodes, at);
  const auto consider = [&](const Vec3& axis) {
    const double axis_length = axis.norm();
    if (!(axis_length > 0.0)) return;
    for (const double sign : {1.0, -1.0}) {
      const Vec3 n = sign / axis_length * axis;
      const double gap = meshes.Gap(touch.nodes, n, at);
      if (gap <= touch.distance) continue;
      touch.distance = gap;
      touch.u = n;
    }
  };
  const Vec3 *a = corners.a, *b = corners.b;
  consider((b[1] - b[0]).cross(b[2] - b[0]));
  consider((a[1] - a[0]).cross(a[2] - a[0]));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      consider((a[(i + 1) % 3] - a[i]).cross(b[(j + 1) % 3] - b[j]));
    }
  }
}

/// Returns whether the tool is in a block's triangle, or just behind it: nearest from within.
bool IsBehind(const MeshPair& meshes, const Touch& touch) {
  const NodesOfPair& nodes = touch.nodes;
  if (!nodes.AreOfBlock()) return false;
  if (!(touch.distance > 0.0)) return true;
  if (touch.distance > meshes.margins.touching) return false;
  // At a sharp edge the direction away from the solid may point behind one of its faces, but less
  // than it points out of another.
  double most = 0.0;
  const Vec3 u_B = meshes.FrameOf(nodes).R.transpose() * touch.u;
  ForEachFaceAt(nodes.shape->mesh, nodes.b, touch.nearest.of_q, [&](const Vec3& n) {
    if (std::fabs(n.dot(u_B)) > std::fabs(most)) most = n.dot(u_B);
  });
  return most < 0.0;
}

/// Returns the plane of two edges of triangles at a pose, its normal on the side of `away`; kNone
/// if they are nearly parallel.
ContactPlane PlaneOfEdges(const MeshPair& meshes, const NodesOfPair& triangles, int of_a, int of_b,
                          const Vec3& away, const RelativePose& at) {
  const Vec3 ea = at.R * EdgeOf(meshes.a.mesh, triangles.a, of_a);
  const Vec3 eb = meshes.FrameOf(triangles).R * EdgeOf(triangles.shape->mesh, triangles.b, of_b);
  const Vec3 across = ea.cross(eb);
  if (across.squaredNorm() <= kParallel * kParallel * ea.squaredNorm() * eb.squaredNorm())
    return {};
  return {ContactPlane::Of::kEdges, eb, static_cast<std::uint8_t>(of_a),
          static_cast<std::uint8_t>(of_b), across.dot(away) < 0.0 ? -1.0 : 1.0};
}

/// Calls visit(plane) for each two edges of a touch's triangles that meet at the nearest points.
template <class Visit>
void ForEachEdges(const MeshPair& meshes, const Touch& touch, const RelativePose& from,
                  Visit visit) {
  const auto is_at = [](Feature of, int edge) {
    return (of.kind == Feature::kEdge && of.index == edge) ||
           (of.kind == Feature::kVertex && (of.index == edge || of.index == (edge + 1) % 3));
  };
  const NearestPoints& nearest = touch.nearest;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (!is_at(nearest.of_p, i) || !is_at(nearest.of_q, j)) continue;
      const ContactPlane plane =
          PlaneOfEdges(meshes, touch.nodes, i, j, nearest.p - nearest.q, from);
      if (plane.of != ContactPlane::Of::kNone) visit(plane);
    }
  }
}

/// Returns whether features at the nearest points of a touch could touch along a plane's normal,
/// were they nearest.
bool MayTouchAlong(const MeshPair& meshes, const Touch& touch, const ContactPlane& plane,
                   const RelativePose& at) {
  Feature of_p = touch.nearest.of_p, of_q = touch.nearest.of_q;
  if (plane.of == ContactPlane::Of::kB) of_q = {Feature::kFace};
  if (plane.of == ContactPlane::Of::kA) of_p = {Feature::kFace};
  if (plane.of == ContactPlane::Of::kEdges) {
    of_p = {Feature::kEdge, plane.edge_a};
    of_q = {Feature::kEdge, plane.edge_b};
  }
  return ConesHold(meshes, touch.nodes, of_p, of_q, NormalAt(meshes, touch, plane, at), at);
}

/// Of the planes that separate a touch by `least` at the motion's beginning, finds the one with the
/// largest gap at the end.
class BestPlane {
 public:
  /// @param room  gap that a plane must exceed at the end [m]
  BestPlane(const MeshPair& meshes, const Touch& touch, const Motion& motion, double least,
            double room = -kInfinity)
      : planes_(meshes, touch.nodes, motion), touch_(touch), least_(least), room_(room) {}

  void Consider(const ContactPlane& other) {
    if (planes_.IsFull()) Find();
    planes_.Add(touch_, other);
  }
  const ContactPlane& Find() {
    planes_.Find([&](int i) {
      if (!(planes_.before(i) >= least_) || planes_.after(i) <= room_) return false;
      room_ = planes_.after(i);
      best_ = planes_.plane(i);
      return false;
    });
    return best_;
  }

 private:
  TriedPlanes planes_;
  const Touch& touch_;
  double least_, room_;
  ContactPlane best_;
};

}  // namespace

[[gnu::flatten]] Corners MeshPair::CornersAt(const NodesOfPair& triangles,
                                             const RelativePose& at) const {
  Corners corners;
  for (int c = 0; c < 3; ++c) {
    corners.a[c] = at.R * a.mesh.Corner(HullTree::TriangleOf(triangles.a), c) + at.p;
    corners.b[c] =
        FrameOf(triangles) * triangles.shape->mesh.Corner(HullTree::TriangleOf(triangles.b), c);
  }
  return corners;
}

[[gnu::flatten]] Vec3 DirectionAt(const MeshPair& meshes, const NodesOfPair& triangles,
                                  const NearestPoints& nearest, const RelativePose& at) {
  const Vec3 across = nearest.Direction();
  if (meshes.IsBall()) return across;
  const Mat3& R_BS = meshes.FrameOf(triangles).R;
  const auto face = [](const ContactMesh& mesh, HullTree::Node node) -> const Vec3& {
    return mesh.triangles()[HullTree::TriangleOf(node)].normal;
  };
  const Feature of_p = nearest.of_p, of_q = nearest.of_q;
  Vec3 n = Vec3::Zero();
  if (of_q.kind == Feature::kFace) {
    n = R_BS * face(triangles.shape->mesh, triangles.b);
  } else if (of_p.kind == Feature::kFace) {
    n = at.R * face(meshes.a.mesh, triangles.a);
  } else if (of_p.kind == Feature::kEdge && of_q.kind == Feature::kEdge) {
    const Vec3 ea = at.R * EdgeOf(meshes.a.mesh, triangles.a, of_p.index);
    const Vec3 eb = R_BS * EdgeOf(triangles.shape->mesh, triangles.b, of_q.index);
    const Vec3 normal = ea.cross(eb);
    const double length = normal.norm();
    if (length > kParallel * ea.norm() * eb.norm()) n = normal / length;
  }
  const double along = n.dot(across);
  // The points of triangles that nearly intersect may belong to other features.
  if (!(std::fabs(along) > 1.0 - kTurned)) return across;
  return along > 0.0 ? n : Vec3(-n);
}

[[gnu::flatten]] Touch TouchAt(const MeshPair& meshes, const NodesOfPair& triangles,
                               const RelativePose& at) {
  Touch touch;
  touch.nodes = triangles;
  touch.nearest = meshes.NearestAt(triangles, at);
  touch.distance = -kInfinity;
  if (touch.nearest.Distance() > 0.0) {
    touch.u = DirectionAt(meshes, triangles, touch.nearest, at);
    touch.distance = meshes.Gap(triangles, touch.u, at);
  }
  touch.in_cone = touch.distance > 0.0 && InCone(meshes, triangles, touch.nearest, touch.u, at);
  if (IsBehind(meshes, touch)) {
    touch.is_behind = touch.by_plane = true;
    touch.in_cone = false;
    if (!(touch.distance > 0.0)) {
      touch.u = meshes.OutwardOf(triangles);
      touch.distance = std::min(0.0, meshes.Gap(triangles, touch.u, at));
    }
    return touch;
  }
  if (!(touch.distance > 0.0)) FindLeastDepth(meshes, at, touch);
  touch.by_plane = touch.distance > 0.0 && !touch.in_cone && !meshes.IsBall();
  return touch;
}

[[gnu::flatten]] Vec3 NormalAt(const MeshPair& meshes, const Touch& touch,
                               const ContactPlane& plane, const RelativePose& at) {
  switch (plane.of) {
    case ContactPlane::Of::kA:
      return at.R * plane.n;
    case ContactPlane::Of::kEdges: {
      const Vec3 ea = EdgeOf(meshes.a.mesh, touch.nodes.a, plane.edge_a);
      return plane.sign * (at.R * ea).cross(plane.n).normalized();
    }
    default:
      return plane.n;
  }
}

double GapAt(const MeshPair& meshes, const NodesOfPair& nodes, const Touch& touch,
             const ContactPlane& plane, const RelativePose& at) {
  return meshes.Gap(nodes, NormalAt(meshes, touch, plane, at), at);
}

bool ConesHold(const MeshPair& meshes, const NodesOfPair& triangles, Feature of_a, Feature of_b,
               const Vec3& n, const RelativePose& at) {
  const auto holds = [](const ContactMesh& mesh, HullTree::Node node, Feature of, const Vec3& n) {
    const ContactMesh::Triangle& t = mesh.triangles()[HullTree::TriangleOf(node)];
    if (of.kind == Feature::kEdge) return mesh.EdgeConeHolds(t.edge[of.index], n);
    if (of.kind == Feature::kVertex) return mesh.VertexConeHolds(t.vertex[of.index], n);
    return true;
  };
  return holds(triangles.shape->mesh, triangles.b, of_b,
               meshes.FrameOf(triangles).R.transpose() * n) &&
         holds(meshes.a.mesh, triangles.a, of_a, -(at.R.transpose() * n));
}

Vec3 SmoothNormal(const MeshPair& meshes, const NodesOfPair& triangles,
                  const NearestPoints& nearest, const Vec3& n) {
  const Placement& X_BS = meshes.FrameOf(triangles);
  const Vec3 n_B = X_BS.R.transpose() * n;
  const Vec3 smooth = triangles.shape->mesh.SmoothNormal(HullTree::TriangleOf(triangles.b),
                                                         X_BS.Inverse() * nearest.q, n_B);
  return smooth == n_B ? n : X_BS.R * smooth;
}

void TriedPlanes::Add(const Touch& touch, const ContactPlane& plane, const Vec3& before,
                      const Vec3& after) {
  planes_[count_] = plane;
  of_[count_] = &touch;
  for (int c = 0; c < 3; ++c) {
    gaps_.n[0][c][count_] = before[c];
    gaps_.n[1][c][count_] = after[c];
  }
  ++count_;
}

[[gnu::flatten]] ContactPlane ChoosePlane(const MeshPair& meshes, const Touch& touch,
                                          const Motion& candidate) {
  const Feature a = touch.nearest.of_p, b = touch.nearest.of_q;
  ContactPlane plane{ContactPlane::Of::kB, touch.u};
  if (touch.distance <= 0.0) return plane;
  if (!touch.in_cone) {
    // The touch belongs to a neighbour: tries the neighbour's face, if that separates
    // this pair as well.
    const double least = touch.by_plane ? kRounding : meshes.margins.LeastAfter(touch.distance);
    BestPlane best(meshes, touch, candidate, least);
    const auto consider = [&](const ContactPlane& plane) {
      if (MayTouchAlong(meshes, touch, plane, candidate.to) ||
          (candidate.moves && MayTouchAlong(meshes, touch, plane, candidate.from))) {
        best.Consider(plane);
      }
    };
    ForEachFace(meshes, touch.nodes, touch.nearest, candidate.from, consider);
    ForEachEdges(meshes, touch, candidate.from, consider);
    if (best.Find().of == ContactPlane::Of::kNone) {
      ForEachFace(meshes, touch.nodes, touch.nearest, candidate.from,
                  [&](const ContactPlane& face) { best.Consider(face); });
    }
    if (best.Find().of != ContactPlane::Of::kNone) return best.Find();
  }
  if (b.kind == Feature::kVertex && a.kind != Feature::kVertex) {
    plane = {ContactPlane::Of::kA, candidate.from.R.transpose() * touch.u};
  } else if (a.kind == Feature::kEdge && b.kind == Feature::kEdge) {
    const ContactPlane edges =
        PlaneOfEdges(meshes, touch.nodes, a.index, b.index, touch.u, candidate.from);
    if (edges.of != ContactPlane::Of::kNone) plane = edges;
  }
  return plane;
}

[[gnu::flatten]] ContactPlane OtherPlane(const MeshPair& meshes, const Touch& touch,
                                         const NearestPoints& nearest, const Vec3& u,
                                         const Motion& candidate) {
  const double enough = meshes.margins.separation - meshes.margins.witness;
  BestPlane best(meshes, touch, candidate, enough, enough);
  const auto consider = [&](const ContactPlane& plane) {
    if (plane.of != touch.plane.of || plane.n != touch.plane.n) best.Consider(plane);
  };
  ForEachFace(meshes, touch.nodes, touch.nearest, candidate.from, consider);
  ForEachFace(meshes, touch.nodes, nearest, candidate.from, consider);
  // A plane across nearest points outside the cones is no contact's.  Its rows would hold the tool
  // if the pair is near.
  const auto across = [&](const Vec3& n, double distance, bool in_cone) {
    if (!in_cone && !meshes.IsBall() && distance <= meshes.margins.touching) return;
    consider(ContactPlane{ContactPlane::Of::kB, n});
    consider(ContactPlane{ContactPlane::Of::kA, candidate.from.R.transpose() * n});
  };
  across(touch.u, touch.distance, touch.in_cone);
  across(u, nearest.Distance(), InCone(meshes, touch.nodes, nearest, u, candidate.to));
  return best.Find();
}

double RotationLoss(const Touch& touch, const ContactPlane& plane, const Vec3& n_old,
                    const Vec3& n_new, const Motion& motion) {
  if (plane.of != ContactPlane::Of::kEdges) return 0.0;
  const Vec3 lever = touch.nearest.p - motion.from.p;
  return 0.25 * (n_new - n_old).norm() * (motion.v + motion.phi.cross(lever)).norm();
}

}  // namespace palpate
