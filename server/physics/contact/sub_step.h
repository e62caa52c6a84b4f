#pragma once

#include <span>

#include "server/physics/contact/mesh_contact.h"
#include "server/physics/rows/contact_rows.h"

namespace palpate {

// One sub-step between meshes, in this order:
//
//   BeginSubStep           finds near pairs, and adds the rows of what touched last
//   CheckTrial, ...        repeated until a trial is free; adds rows for what is not
//   Reconcile's functions  test whether those rows are the geometry's at the trial
//   EndSubStep             moves the tool; the front keeps the planes
//
// Certify keeps the invariant.  Rows are added on violation.  The zero step changes no gap, so it
// is always free.  Drawings: README.md, and ../surface/README.md.
// Real-time: no allocation, lock, log or clock.  Deterministic.

/// When Certify may stop at a trial that is not free.
enum class Until {
  kFirst,   ///< when one pair has no plane
  kEnough,  ///< when limits::mesh::kEnough have none: there will be another trial
};

/// Searches for planes that separate every pair of triangles throughout the trial [v; phi] from the
/// beginning of the sub-step, and leaves them in `near`.  One plane separates each pair at both
/// ends, so the straight way between them is free too.  At the end the gap is at least h, or no
/// less than the pair's distance was (except for kRounding).  Patches that such a plane separates
/// are not split.
///
/// Returns 0 if every pair has a plane; otherwise the number of pairs that have none or, once the
/// looks are spent, were not examined.  With kEnough, `contact.open` lists the triangles among
/// them; those within their cones have chosen the planes of their rows.
int Certify(MeshContact& contact, const Vec3& v, const Vec3& phi, Until until) noexcept;

/// Updates the front at `from`, and adds the rows of those `active` pairs that still touch.  This
/// includes pairs outside their cones; otherwise a tool at rest would find them again in each step,
/// at slightly different places.
/// @param most_looks  of the sub-step.  Once they are spent, pairs whose planes do not hold count
///                    as not separate.
void BeginSubStep(MeshContact& contact, const Kernels& kernels, SeparationFront& front,
                  const ToolPose& from, std::span<const ContactId> active, std::int64_t most_looks,
                  ContactRows& rows) noexcept;

/// Returns whether the trial [v; phi] is free.  If not, adds rows for pairs without a plane, or
/// recomputes those rows that the trial violates.
bool CheckTrial(MeshContact& contact, const Vec3& v, const Vec3& phi, ContactRows& rows) noexcept;
/// CheckTrial without rows: stops at the first pair without a plane.
bool IsFree(MeshContact& contact, const Vec3& v, const Vec3& phi) noexcept;

/// Call if no trial is free: EndSubStep then leaves the tool where it is.
void Stay(MeshContact& contact) noexcept;
/// Moves the tool to the trial that was examined last, which must be free (after Stay, the tool
/// stays), and stores the planes in the front.
void EndSubStep(MeshContact& contact) noexcept;

/// Returns whether, at a pose, no triangle of the tool intersects one of the objects.  A tool
/// wholly inside a closed mesh intersects none.  Not real-time.
bool IsFree(const ToolAndBodies& meshes, const ToolPose& at);

}  // namespace palpate
