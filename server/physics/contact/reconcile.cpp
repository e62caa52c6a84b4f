#include <algorithm>
#include <cmath>

#include "server/physics/contact/sub_step.h"
#include "server/physics/limits.h"

namespace palpate {
namespace {

using namespace limits::mesh;

/// Calls mend(row, touch) for the active rows at the candidate, and returns how many it changed.
/// Pairs that meet at one corner have equal rows, of which the QP makes one active.  If that one
/// changes, the others are mended too; otherwise one more would appear in each candidate.
template <class Mend>
int MendRows(MeshContact& contact, std::span<const int> active, const FrameRows& rows, Mend mend) {
  int changed = 0;
  const auto mend_row = [&](int row) {
    Touch* touch = contact.TouchOfRow(row);
    return touch != nullptr && touch->distance > 0.0 && mend(row, *touch);
  };
  for (const int row : active) changed += mend_row(row) ? 1 : 0;
  if (changed == 0 || contact.meshes.IsBall()) return changed;
  for (int row = 0; row < rows.count(); ++row) {
    if (rows.Left(row, contact.motion.v, contact.motion.phi) <= contact.meshes.margins.witness)
      mend_row(row);
  }
  return changed;
}

/// Returns the gap of a row's own point at the candidate [m].
double GapOfRow(const MeshContact& contact, int row, const FrameRows& rows) {
  return rows.Left(row, contact.motion.v, contact.motion.phi) +
         contact.of_rows.asked[static_cast<std::size_t>(row)];
}

/// Returns whether a row's corner lies over a face of the row's normal at the candidate, its own
/// triangle or one beside it that is flush with it.
bool IsOverFace(const MeshContact& contact, const Touch& touch, int row, double turned,
                const FrameRows& rows) {
  const MeshPair& meshes = contact.meshes;
  if (meshes.IsBall() || touch.plane.of == ContactPlane::Of::kEdges) return false;
  const int c = row == touch.row[0] ? 0 : row == touch.row[1] ? 1 : 2;
  const RelativePose& at = contact.motion.to;
  const Vec3 n = NormalAt(meshes, touch, touch.plane, at);
  if ((n - rows.normal(row)).norm() > turned) return false;
  const Corners corners = meshes.CornersAt(touch.nodes, at);
  const double apart = kWitnessRatio * GapOfRow(contact, row, rows) + meshes.margins.witness;
  if (apart > meshes.margins.touching) return false;  // and the search would not end soon
  if (touch.plane.of == ContactPlane::Of::kA) {
    return HasFaceAt(meshes.a, at.R.transpose() * (corners.b[c] - at.p), at.R.transpose() * n,
                     apart, turned);
  }
  const Placement& X_BS = meshes.FrameOf(touch.nodes);
  return HasFaceAt(*touch.nodes.shape, X_BS.Inverse() * corners.a[c], X_BS.R.transpose() * n, apart,
                   turned);
}

/// Returns whether a row is of two edges that can touch along its normal at the candidate, though
/// the nearest points of their triangles lie at an end of one.
bool IsOfEdges(const MeshContact& contact, const Touch& touch, int row, double turned,
               const FrameRows& rows) {
  const ContactPlane& plane = touch.plane;
  if (plane.of != ContactPlane::Of::kEdges) return false;
  const RelativePose& at = contact.motion.to;
  const Vec3 n = NormalAt(contact.meshes, touch, plane, at);
  return (n - rows.normal(row)).norm() <= turned &&
         ConesHold(contact.meshes, touch.nodes, {Feature::kEdge, plane.edge_a},
                   {Feature::kEdge, plane.edge_b}, n, at);
}

/// Returns whether a contact gives a row at the candidate: its pair is no farther apart than the
/// row says, and touches there within its cones along the row's normal, or the row's corner is over
/// a face.
bool IsOfContact(const MeshContact& contact, const Touch& touch, int row, double turned,
                 const FrameRows& rows) {
  const MeshPair& meshes = contact.meshes;
  const RelativePose& at = contact.motion.to;
  const NearestPoints nearest = meshes.NearestAt(touch.nodes, at);
  if (nearest.Distance() - meshes.a.radius >
      kWitnessRatio * GapOfRow(contact, row, rows) + meshes.margins.witness) {
    return false;
  }
  const Vec3 u = DirectionAt(meshes, touch.nodes, nearest, at);
  return ((u - rows.normal(row)).norm() <= turned && InCone(meshes, touch.nodes, nearest, u, at)) ||
         IsOverFace(contact, touch, row, turned, rows) ||
         IsOfEdges(contact, touch, row, turned, rows);
}

/// Gives a row that does not touch at the candidate another plane, if there is any; and a ball's
/// row the smooth surface's normal there.  Returns whether the change is large enough to affect the
/// force. A crease is not smooth: the ball goes straight past it, and round it in the next
/// sub-steps (Turned).
bool Retract(MeshContact& contact, Touch& touch, int row, FrameRows& rows) {
  const MeshPair& meshes = contact.meshes;
  const Motion& motion = contact.motion;
  const NearestPoints nearest = meshes.NearestAt(touch.nodes, motion.to);
  if (!(nearest.squared > 0.0)) return false;
  const double now = nearest.Distance() - meshes.a.radius;
  const Vec3 u = DirectionAt(meshes, touch.nodes, nearest, motion.to);
  const bool touches = GapOfRow(contact, row, rows) <= kWitnessRatio * now + meshes.margins.witness;
  if (!touches || !(InCone(meshes, touch.nodes, nearest, u, motion.to) ||
                    IsOverFace(contact, touch, row, kTurned, rows))) {
    const ContactPlane other = OtherPlane(meshes, touch, nearest, u, motion);
    if (other.of == ContactPlane::Of::kNone) return false;
    // A plane of the same direction, as that of the next triangle of a flat face, changes nothing.
    const Vec3 n = NormalAt(meshes, touch, other, motion.to);
    if (touches && (n - rows.normal(row)).norm() <= kSame) return false;
    TakeOut(touch, rows);
    touch.plane = other;
    return touch.is_mended = true;
  }
  if (!meshes.IsBall() || !TurnsRows(contact)) return false;
  const Vec3 along = SmoothNormal(meshes, touch.nodes, nearest, u);
  const double off = std::abs(GapOfRow(contact, row, rows) - now);
  if (along == u ||
      ((along - rows.normal(row)).norm() <= kTurned && off <= meshes.margins.witness)) {
    return false;
  }
  const double asked = Asked(contact, touch.distance);
  contact.of_rows.asked[static_cast<std::size_t>(row)] = asked;
  const Vec3 lever = rows.lever(row);
  rows.SetRow(row, along, lever, lever.cross(along), now - asked - along.dot(motion.v));
  return true;
}

}  // namespace

int Retract(MeshContact& contact, std::span<const int> active, FrameRows& rows) noexcept {
  return MendRows(contact, active, rows, [&](int row, Touch& touch) {
    return !touch.is_mended && Retract(contact, touch, row, rows);
  });
}

int Relinearise(MeshContact& contact, std::span<const int> active, double most,
                FrameRows& rows) noexcept {
  return MendRows(contact, active, rows, [&](int row, Touch& touch) {
    if (touch.is_mended) return false;
    const TouchRowsAtCandidate of = RowsAt(contact, touch);
    for (int k = 0; k < of.count; ++k) {
      if (touch.row[of.row[k].slot % 3] != row) continue;
      const double off = std::abs(of.row[k].now - GapOfRow(contact, row, rows));
      if (off <= contact.meshes.margins.witness &&
          rows.AngleTo(row, of.row[k].n, of.row[k].by_rotation) <= most) {
        return false;
      }
      SetRow(contact, touch, of.row[k], rows);
      touch.is_mended = true;
    }
    return touch.is_mended;
  });
}

bool AreOfContacts(const MeshContact& contact, std::span<const int> active, double most,
                   const FrameRows& rows) noexcept {
  return std::ranges::all_of(active, [&](int row) {
    const Touch* touch = contact.TouchOfRow(row);
    return touch == nullptr || !(touch->distance > 0.0) ||
           IsOfContact(contact, *touch, row, most, rows);
  });
}

int Release(MeshContact& contact, std::span<const int> active, FrameRows& rows) noexcept {
  return MendRows(contact, active, rows, [&](int, Touch& touch) {
    if (touch.by_plane) TakeOut(touch, rows);
    return touch.by_plane;
  });
}

Mat3 CurvatureOf(const MeshContact& contact, int row) noexcept {
  const Touch* touch = contact.TouchOfRow(row);
  if (!contact.meshes.IsBall() || touch == nullptr) return Mat3::Zero();
  const Feature of = touch->nearest.of_q;
  if (!touch->in_cone || of.kind == Feature::kFace) return Mat3::Zero();
  const ContactMesh& mesh = touch->nodes.shape->mesh;
  const std::uint32_t triangle = HullTree::TriangleOf(touch->nodes.b);
  const ContactMesh::Triangle& t = mesh.triangles()[triangle];
  const auto faces = of.kind == Feature::kEdge ? mesh.FacesAtEdge(t.edge[of.index])
                                               : mesh.FacesAtVertex(t.vertex[of.index]);
  const Vec3& u = touch->u;
  const Mat3& R_BS = contact.meshes.FrameOf(touch->nodes).R;
  const bool flat = std::all_of(faces.begin(), faces.end(), [&](std::uint32_t face) {
    return (R_BS * mesh.triangles()[face].normal).cross(u).norm() <= kTurned;
  });
  if (flat || SmoothNormal(contact.meshes, touch->nodes, touch->nearest, u) != u)
    return Mat3::Zero();
  const double length = touch->nearest.Distance();
  if (of.kind == Feature::kVertex) return (Mat3::Identity() - u * u.transpose()) / length;
  const Vec3 edge =
      R_BS * (mesh.Corner(triangle, (of.index + 1) % 3) - mesh.Corner(triangle, of.index));
  const Vec3 across = edge.cross(u).normalized();
  return across * across.transpose() / length;
}

double Turned(const MeshContact& contact, std::span<const int> active,
              const FrameRows& rows) noexcept {
  const MeshPair& meshes = contact.meshes;
  double most = 0.0;
  for (const int row : active) {
    const Touch* touch = contact.TouchOfRow(row);
    if (touch == nullptr || !(touch->distance > 0.0)) continue;
    const NearestPoints nearest = meshes.NearestAt(touch->nodes, contact.motion.to);
    const double apart = kWitnessRatio * GapOfRow(contact, row, rows) + meshes.margins.witness;
    if (!(nearest.squared > 0.0) || nearest.Distance() - meshes.a.radius > apart) return kInfinity;
    const Vec3 along = SmoothNormal(meshes, touch->nodes, nearest, nearest.Direction());
    most = std::max({most, (along - rows.normal(row)).norm(),
                     (CurvatureOf(contact, row) * contact.motion.v).norm()});
  }
  return most;
}

}  // namespace palpate
