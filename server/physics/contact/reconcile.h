#pragma once

#include <span>

#include "server/physics/contact/mesh_contact.h"
#include "server/physics/rows/contact_rows.h"

namespace palpate {

// Whether the rows that hold the tool at a free trial are those that the geometry gives there: the
// convergence test of a sequential quadratic program.  Each returns how many touches it changed;
// where that is not 0, the rows are to be solved again.  Rows of leaves, and of pairs that
// intersect, are left alone.

/// Takes the rows of touches out that do not touch at the trial and that another plane keeps apart:
/// the touch gets that plane.  A ball's rows take the smooth surface's normal of the trial.
int Retract(MeshContact& contact, std::span<const int> active, ContactRows& rows) noexcept;
/// Makes rows anew whose direction in the configuration space has turned by limits::mesh::kTurned,
/// once in a sub-step.
int Relinearise(MeshContact& contact, std::span<const int> active, ContactRows& rows) noexcept;
/// Lets the rows go of touches that do not touch at the trial: their planes are not those of
/// contacts, and hinder the tool without a cause.
int Release(MeshContact& contact, std::span<const int> active, ContactRows& rows) noexcept;
/// Undoes the last Release.
void PutBack(MeshContact& contact, ContactRows& rows) noexcept;

/// A ball's row goes straight past the edge or the corner that it touches: the derivative [1/m]
/// of its normal by the ball's way round it.  Zero of other rows.
Mat3 CurvatureOf(const MeshContact& contact, int row) noexcept;
/// How far the direction in which a ball touches at the trial has left those of the active rows,
/// or the curvature of one has made the ball go past it [rad].
double Turned(const MeshContact& contact, std::span<const int> active,
              const ContactRows& rows) noexcept;

}  // namespace palpate
