#pragma once

#include <span>

#include "server/physics/contact/mesh_contact.h"
#include "server/physics/rows/contact_rows.h"

namespace palpate {

// These functions test whether the rows that hold the tool at a free trial are those that the
// geometry gives there: the convergence test of a sequential quadratic program.  The first three
// return how many touches they changed; if that is not 0, the rows must be solved again.  Rows of
// leaves, and of pairs that intersect, are not changed.

/// Removes the rows of each touch that does not touch at the trial if another plane separates it;
/// the touch takes that plane.  Rows of a ball take the smooth surface's normal at the trial.
int Retract(MeshContact& contact, std::span<const int> active, ContactRows& rows) noexcept;
/// Recomputes each row whose direction in configuration space has turned by limits::mesh::kTurned,
/// at most once in a sub-step.
int Relinearise(MeshContact& contact, std::span<const int> active, ContactRows& rows) noexcept;
/// Removes the rows of touches that do not touch at the trial: no contact gives their planes, so
/// they would hinder the tool without a cause.
int Release(MeshContact& contact, std::span<const int> active, ContactRows& rows) noexcept;
/// Undoes the last Release.
void PutBack(MeshContact& contact, ContactRows& rows) noexcept;

/// Returns the derivative [1/m] of the normal of a ball's row by the ball's motion round the edge
/// or corner that it touches, which the straight row neglects.  Zero for other rows.
Mat3 CurvatureOf(const MeshContact& contact, int row) noexcept;
/// Returns by how much the direction in which a ball touches at the trial differs from those of the
/// active rows [rad], or by how much the curvature of a row has made the ball overshoot.
double Turned(const MeshContact& contact, std::span<const int> active,
              const ContactRows& rows) noexcept;

}  // namespace palpate
