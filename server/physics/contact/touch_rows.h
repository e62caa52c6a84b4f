#pragma once

#include "server/physics/contact/mesh_contact.h"
#include "server/physics/rows/contact_rows.h"

namespace palpate {

/// A row of a touch's plane, exact at a trial: corners of the one triangle stay above a plane of
/// the other.
struct TouchRow {
  int slot;            ///< in touch.row, modulo 3: which corner; 3 of edges
  Vec3 n;              ///< what the gap grows by as the tool moves
  Vec3 lever;          ///< of the contact at the sub-step's beginning, from the reference point [m]
  Vec3 by_turning;     ///< what the gap grows by as phi grows [m]
  double before, now;  ///< gap at the sub-step's beginning and at the trial [m]
};
struct TouchRowsAtTrial {
  TouchRow row[3];
  int count;
};

/// Names the rows of two triangles.
ContactId IdOf(const NodesOfPair& triangles, int corner = 0);
/// The rows of a touch's plane at the trial.
TouchRowsAtTrial RowsAt(const MeshContact& contact, const Touch& touch);

/// Adds the rows that the trial breaks, of touches that Certify found open: of those within their
/// cones; where those give none, of the others, for a neighbour is nearer, and its rows mostly keep
/// them apart too.
void AddRowsOfOpen(MeshContact& contact, ContactRows& rows);
/// Adds the rows of those corners of a near pair's touch that touch.
void AddRowsThatTouch(MeshContact& contact, NearPairs::Index k, ContactRows& rows);
/// Adds or changes a row: a . x >= what it asks for at the trial.
void SetRow(MeshContact& contact, Touch& touch, const TouchRow& row, ContactRows& rows);
/// Makes all rows anew, exact where the sub-step begins: each allows the zero step.
void RelineariseAtStart(MeshContact& contact, ContactRows& rows);
/// A ball's rows turn with the smooth surface from trial to trial, and the ball's way with them.
/// Where that takes many they stay as they are, and the next sub-step turns them.
inline bool TurnsRows(const MeshContact& contact) {
  return contact.trial <= limits::mesh::kTrustedTrials;
}
/// Takes a touch's rows out.
void TakeOut(Touch& touch, ContactRows& rows);

/// What a row asks for of a pair that has `before` [m]: the separation, or some of what it lacks.
double Asked(const MeshContact& contact, double before);
/// Rows ask for some of the separation that a pair has lost.  Where that would lift the tool
/// against the spring a tool at rest would never stay: from here on, to the sub-step's end, they
/// ask for what the pair has.  False where they did so before.
bool GiveUpRegain(MeshContact& contact, ContactRows& rows);

}  // namespace palpate
