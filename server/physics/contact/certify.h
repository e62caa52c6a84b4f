#pragma once

#include "server/physics/contact/mesh_contact.h"

namespace palpate {

/// When Certify has seen enough of a trial that is not free.
enum class Until {
  kFirst,   ///< one pair has no plane
  kEnough,  ///< limits::mesh::kEnough have none: the next trial will be another one
};

/// Looks for planes that keep every pair of triangles apart throughout the trial [v; phi] from the
/// sub-step's beginning, and leaves them in `near`.  One plane separates each pair at both ends, so
/// the straight way between is free too.  At the end its gap is h at least, or no less than
/// the pair's distance was (but for kRounding).  Patches that such a plane separates are not
/// looked into.
///
/// Returns 0 where every pair has one.  Else more: a count of pairs that have none or, where the
/// looks are spent, were not looked at.  With kEnough `contact.open` has the triangles among them;
/// those within their cones have chosen the planes of their rows.
/// Real-time, deterministic.
int Certify(MeshContact& contact, const Vec3& v, const Vec3& phi, Until until) noexcept;

}  // namespace palpate
