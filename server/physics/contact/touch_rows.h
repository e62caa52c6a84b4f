#pragma once

#include "server/physics/contact/mesh_contact.h"
#include "server/physics/rows/contact_rows.h"

namespace palpate {

/// A row of a touch's plane, exact at a trial: a corner of one triangle stays above a
/// plane of the other.
struct TouchRow {
  int slot;    ///< index into touch.row, modulo 3: the corner; 3 for edges
  Vec3 n;      ///< rate of the gap as the tool moves
  Vec3 lever;  ///< from the reference point to the contact, at the beginning of the sub-step [m]
  Vec3 by_turning;     ///< rate of the gap as phi grows [m]
  double before, now;  ///< gap at the sub-step's beginning and at the trial [m]
};
struct TouchRowsAtTrial {
  TouchRow row[3];
  int count;
};

/// Returns the id of a row of two triangles.
ContactId IdOf(const NodesOfPair& triangles, int corner = 0);
/// Returns the rows of a touch's plane at the trial.
TouchRowsAtTrial RowsAt(const MeshContact& contact, const Touch& touch);

/// Adds the rows that the trial violates, of touches that Certify found open.  Touches within their
/// cones come first; only if those give no row, the others: in these a neighbour is nearer, and its
/// rows mostly keep them apart too.
void AddRowsOfOpen(MeshContact& contact, ContactRows& rows);
/// Adds the rows of those corners of a near pair's touch that touch.
void AddRowsThatTouch(MeshContact& contact, NearPairs::Index k, ContactRows& rows);
/// Adds or changes a row, with what it asks for at the trial.
void SetRow(MeshContact& contact, Touch& touch, const TouchRow& row, ContactRows& rows);
/// Recomputes all rows, exact at the beginning of the sub-step: each allows the zero step.
void RelineariseAtStart(MeshContact& contact, ContactRows& rows);
/// Returns whether a ball's rows still turn with the smooth surface from trial to trial,
/// which also changes the ball's way.  After many trials they stay as they are, and the
/// next sub-step turns them.
inline bool TurnsRows(const MeshContact& contact) {
  return contact.trial <= limits::mesh::kTrustedTrials;
}
/// Removes a touch's rows.
void TakeOut(Touch& touch, ContactRows& rows);

/// Returns the separation [m] that a row asks for if its pair has `before` [m]: the full
/// separation, or a part of what is missing.
double Asked(const MeshContact& contact, double before);
/// Stops rows, until the end of the sub-step, from asking for separation that their pairs have
/// lost: if regaining it would lift the tool against the spring, a tool at rest would never stay.
/// Returns false if they had already stopped.
bool GiveUpRegain(MeshContact& contact, ContactRows& rows);

}  // namespace palpate
