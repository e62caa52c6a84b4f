#include <algorithm>

#include "server/physics/contact/sub_step.h"
#include "server/physics/limits.h"

namespace palpate {
namespace {

using namespace limits::mesh;

/// Returns the exact rate at which the gap along a plane of crossing edges grows with a rotation at
/// the candidate.  A's lowest point moves, and n turns with A's edge, while that point
/// and B's highest point are d apart.  With w = (d - n (n . d)) / ((ea x eb) . n), the
/// rate is
///   (x - p) x n + ea x (eb x w).
/// If the edges themselves are nearest, it is l x n, with l the lever of the place where they
/// cross. At a candidate with a large rotation a corner has come past them, and that lever is
/// wrong: in a peg's hole such a row shut out A's own place by 150 um.
Vec3 EdgesByRotation(const MeshContact& contact, const Touch& touch, const Vec3& n) {
  const RelativePose& at = contact.motion.to;
  const Corners corners = contact.meshes.CornersAt(touch.nodes, at);
  // If a corner is only as near as the edges, the touch belongs to the edges.
  const auto farthest = [&](const Vec3* corner, int edge, const Vec3& along) {
    Vec3 best = corner[edge];
    for (int c = 0; c < 3; ++c) {
      if (along.dot(corner[c] - best) > contact.meshes.margins.witness) best = corner[c];
    }
    return best;
  };
  const Vec3 *a = corners.a, *b = corners.b;
  const int i = touch.plane.edge_a, j = touch.plane.edge_b;
  const Vec3 lowest = farthest(a, i, -n);
  const Vec3 d = lowest - farthest(b, j, n);
  const Vec3 ea = a[(i + 1) % 3] - a[i];
  const Vec3 eb = b[(j + 1) % 3] - b[j];
  const Vec3 w = (d - n.dot(d) * n) / ea.cross(eb).dot(n);
  return (lowest - at.p).cross(n) + ea.cross(eb.cross(w));
}

/// Returns the point of A's edge where a plane's edges cross, at the candidate; an end of it if
/// they have passed each other.
Vec3 CrossingOf(const MeshContact& contact, const Touch& touch) {
  const Corners corners = contact.meshes.CornersAt(touch.nodes, contact.motion.to);
  const int i = touch.plane.edge_a, j = touch.plane.edge_b;
  const Vec3 &a = corners.a[i], &b = corners.b[j];
  const Vec3 ea = corners.a[(i + 1) % 3] - a, eb = corners.b[(j + 1) % 3] - b;
  const Vec3 across = ea.cross(eb);
  const double share = (b - a).cross(eb).dot(across) / across.squaredNorm();
  return a + std::clamp(share, 0.0, 1.0) * ea;
}

/// Returns whether n is the normal of a triangle.
bool IsFaceOf(const Vec3* corner, const Vec3& n) {
  const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  return normal.cross(n).norm() <= kTurned * normal.norm();
}

/// Returns the gap of a touch along its plane at the beginning of the sub-step [m].
double GapBefore(const MeshContact& contact, const Touch& touch) {
  return GapAt(contact.meshes, touch.nodes, touch, touch.plane, contact.motion.from);
}

/// Adds or changes the rows of a touch for which `wanted` holds; returns whether there was any.
template <class Wanted>
bool SetRows(MeshContact& contact, Touch& touch, FrameRows& rows, Wanted wanted) {
  const TouchRowsAtCandidate of = RowsAt(contact, touch);
  bool set = false;
  for (int i = 0; i < of.count; ++i) {
    if (!wanted(of.row[i])) continue;
    SetRow(contact, touch, of.row[i], rows);
    set = true;
  }
  return set;
}

}  // namespace

ContactId IdOf(const NodesOfPair& triangles, int corner) {
  return {triangles.number, static_cast<std::int32_t>(HullTree::TriangleOf(triangles.a)),
          static_cast<std::int32_t>(HullTree::TriangleOf(triangles.b)), corner};
}

TouchRowsAtCandidate RowsAt(const MeshContact& contact, const Touch& touch) {
  const MeshPair& meshes = contact.meshes;
  const Motion& motion = contact.motion;
  const ContactPlane& plane = touch.plane;
  const NodesOfPair& nodes = touch.nodes;
  const Vec3 n_old = NormalAt(meshes, touch, plane, motion.from);
  const Vec3 n_new = NormalAt(meshes, touch, plane, motion.to);
  // phi is incremented on the left of a rotation by phi: w . J_l(phi) dphi, J_l = 1 + 1/2 [phi]x.
  const auto by_phi = [&](const Vec3& w) -> Vec3 { return w - 0.5 * motion.phi.cross(w); };
  TouchRowsAtCandidate of;
  if (plane.of == ContactPlane::Of::kEdges) {
    const Vec3 lever = CrossingOf(contact, touch) - motion.to.p;
    const double before = meshes.Gap(nodes, n_old, motion.from);
    const double now = meshes.Gap(nodes, n_new, motion.to);
    const double loss = RotationLoss(touch, plane, n_old, n_new, motion);
    const bool holds = std::min(before, now) - loss >= 0.5 * std::min(meshes.margins.free, before);
    of.row[0] = {3,
                 n_new,
                 lever - meshes.a.radius * n_new,
                 by_phi(EdgesByRotation(contact, touch, n_new)),
                 before,
                 holds ? now : std::min(now, touch.LeastAfter(meshes.margins, before)) - loss,
                 true};
    of.count = 1;
    return of;
  }
  const Corners old = meshes.CornersAt(nodes, motion.from),
                now = meshes.CornersAt(nodes, motion.to);
  const bool of_a = plane.of == ContactPlane::Of::kB;
  const double plane_old =
      of_a ? meshes.High(nodes, n_old) : meshes.Low(nodes.a, n_old, motion.from);
  const double plane_new = of_a ? plane_old : meshes.Low(nodes.a, n_new, motion.to);
  // A ball's row has the normal of the smooth surface that the mesh approximates; its right-hand
  // side is that of the triangles, which the ball may not enter.
  const Vec3 along = meshes.IsBall()
                         ? SmoothNormal(meshes, nodes, meshes.NearestAt(nodes, motion.to), n_new)
                         : n_new;
  const Vec3 down = of_a ? Vec3(meshes.a.radius * n_new) : Vec3::Zero();
  const double sign = of_a ? 1.0 : -1.0;
  of.count = of_a && meshes.IsBall() ? 1 : 3;
  for (int c = 0; c < of.count; ++c) {
    const Vec3& corner_old = of_a ? old.a[c] : old.b[c];
    const Vec3& corner_new = of_a ? now.a[c] : now.b[c];
    of.row[c] = {
        c,
        along,
        corner_old - motion.from.p - down,
        by_phi((corner_new - motion.to.p - down).cross(along)),
        sign * (n_old.dot(corner_old - down) - plane_old),
        sign * (n_new.dot(corner_new - down) - plane_new),
        meshes.IsBall() || ((touch.in_cone || IsFaceOf(of_a ? now.b : now.a, along)) &&
                            IsOver(of_a ? now.b : now.a, corner_new, meshes.margins.touching))};
  }
  return of;
}

void SetRow(MeshContact& contact, Touch& touch, const TouchRow& of, FrameRows& rows) {
  TouchRows& of_rows = contact.of_rows;
  int& row = touch.row[of.slot % 3];
  const bool stays = row >= 0 && contact.meshes.IsBall() && !TurnsRows(contact);
  if (row < 0) {
    if (rows.count() >= rows.max_rows()) return;
    row = rows.count();
    rows.AddRow(of.n, of.lever, of.before, IdOf(touch.nodes, of.slot));
    of_rows.touch.resize(static_cast<std::size_t>(rows.count()), nullptr);
    of_rows.touch[static_cast<std::size_t>(row)] = &touch;
  }
  const double asked = Asked(contact, GapBefore(contact, touch));
  const Motion& motion = contact.motion;
  const Vec3 n = stays ? rows.normal(row) : of.n;
  rows.SetRow(row, n, of.lever, of.by_rotation,
              of.now - asked - n.dot(motion.v) - of.by_rotation.dot(motion.phi));
  of_rows.asked[static_cast<std::size_t>(row)] = asked;
}

bool AddRowsOfOpen(MeshContact& contact, FrameRows& rows) {
  const auto add = [&](bool in_cone, bool over) {
    bool added = false;
    for (const NearPairs::Index k : contact.open) {
      Touch& touch = contact.TouchOf(k);
      if (touch.in_cone != in_cone) continue;
      if (touch.plane.of == ContactPlane::Of::kNone) {
        touch.plane = ChoosePlane(contact.meshes, touch, contact.motion);
      }
      const double least = touch.LeastAfter(contact.meshes.margins, GapBefore(contact, touch));
      const auto is_broken = [&](const TouchRow& row) {
        return row.now < least && row.is_over >= over;
      };
      added = SetRows(contact, touch, rows, is_broken) || added;
    }
    return added;
  };
  return add(true, true) || add(true, false) || add(false, false);
}

void AddRowsThatTouch(MeshContact& contact, NearPairs::Index k, FrameRows& rows) {
  Touch& touch = contact.TouchOf(k);
  if (touch.distance <= 0.0 || touch.plane.of != ContactPlane::Of::kNone) return;
  touch.plane = ChoosePlane(contact.meshes, touch, contact.motion);
  const double touching =
      kWitnessRatio * GapBefore(contact, touch) + contact.meshes.margins.witness;
  SetRows(contact, touch, rows,
          [&](const TouchRow& row) { return row.is_over && row.before <= touching; });
}

void RelineariseAtStart(MeshContact& contact, FrameRows& rows) {
  contact.motion = Motion(contact.motion.from);
  for (Touch& touch : contact.touches) {
    if (touch.plane.of == ContactPlane::Of::kNone) continue;
    SetRows(contact, touch, rows, [&](const TouchRow& of) { return touch.row[of.slot % 3] >= 0; });
    for (const int row : touch.row) {
      if (row >= 0) rows.SetGap(row, std::max(rows.gap(row), 0.0));
    }
  }
}

void TakeOut(Touch& touch, FrameRows& rows) {
  for (int& row : touch.row) {
    if (row >= 0) rows.Loosen(row);
    row = -1;
  }
}

double Asked(const MeshContact& contact, double before) {
  const limits::mesh::Margins& margins = contact.meshes.margins;
  const double regain = contact.of_rows.regains ? margins.regain : 0.0;
  return std::min(contact.of_rows.least, before + regain);
}

double PriceOfRegain(const MeshContact& contact, const QpResult& qp) {
  double price = 0.0;
  for (int i = 0; i < qp.active && contact.of_rows.regains; ++i) {
    const Touch* touch = contact.TouchOfRow(qp.row[i]);
    if (touch == nullptr) continue;
    const double has = std::min(contact.meshes.margins.separation, GapBefore(contact, *touch));
    price += qp.multiplier[i] * (contact.of_rows.asked[static_cast<std::size_t>(qp.row[i])] - has);
  }
  return price;
}

bool GiveUpRegain(MeshContact& contact, FrameRows& rows) {
  TouchRows& of_rows = contact.of_rows;
  if (!of_rows.regains) return false;
  of_rows.regains = false;
  // A pair outside its cones is farther apart than the contact beside it.  If it asked for what it
  // has, and the contact for less, it would hold the tool.  No row may ask for less than h, without
  // which no candidate is free.
  for (const Touch* touch : of_rows.touch) {
    if (touch == nullptr || !touch->in_cone || contact.meshes.IsBall()) continue;
    of_rows.least = std::min(of_rows.least, touch->distance);
  }
  of_rows.least = std::max(of_rows.least, contact.meshes.margins.free);
  for (int row = 0; row < rows.count(); ++row) {
    const Touch* touch = contact.TouchOfRow(row);
    if (touch == nullptr) continue;
    const double asks = Asked(contact, GapBefore(contact, *touch));
    double& asked = of_rows.asked[static_cast<std::size_t>(row)];
    rows.SetGap(row, rows.gap(row) + asked - asks);
    asked = asks;
  }
  return true;
}

}  // namespace palpate
