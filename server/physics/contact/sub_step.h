#pragma once

#include <span>

#include "server/physics/contact/mesh_contact.h"
#include "server/physics/rows/contact_rows.h"

namespace palpate {

// One sub-step between meshes, in this order:
//
//   BeginSubStep           near pairs, and rows of what touched last
//   CheckTrial, ...        until one is free; rows come of what is not
//   Reconcile's functions  whether those rows are the geometry's there
//   EndSubStep             the tool goes, the front keeps the planes
//
// The invariant is Certify's.  Rows come on violation.  The zero step changes no gap: it is always
// free.  Drawings: README.md, and ../surface/README.md.
// Real-time: no allocation, lock, log or clock.  Deterministic.

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
int Certify(MeshContact& contact, const Vec3& v, const Vec3& phi, Until until) noexcept;

/// Updates the front at `from`, and adds the rows of the `active` ones' pairs that still touch:
/// those out of their cones too, or a tool at rest would find them anew in each step, a little off.
/// @param most_looks  what the sub-step may cost; pairs that there are no looks left for count as
///                    not apart where their planes do not hold.
void BeginSubStep(MeshContact& contact, const Kernels& kernels, SeparationFront& front,
                  const ToolPose& from, std::span<const ContactId> active, std::int64_t most_looks,
                  ContactRows& rows) noexcept;

/// Whether the trial [v; phi] is free.  If not, rows of those pairs that have no plane are added,
/// or made anew where the trial breaks them.
bool CheckTrial(MeshContact& contact, const Vec3& v, const Vec3& phi, ContactRows& rows) noexcept;
/// The same without rows: it ends with the first pair that has no plane.
bool IsFree(MeshContact& contact, const Vec3& v, const Vec3& phi) noexcept;

/// No trial is free: EndSubStep is to leave the tool where it is.
void Stay(MeshContact& contact) noexcept;
/// The tool goes to the trial that was looked at last, which must be free; after Stay it stays.
/// The planes go into the front.
void EndSubStep(MeshContact& contact) noexcept;

/// Whether no triangle of the tool meets one of the objects at a pose.  What lies wholly inside a
/// closed mesh meets none.  Not real-time.
bool IsFree(const ToolAndBodies& meshes, const ToolPose& at);

}  // namespace palpate
