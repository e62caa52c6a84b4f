#pragma once

namespace palpate {

/// Hashes of the sources of which this was built (revision.cmake names them), 12 hexadecimal
/// digits.  They say which build it was where version numbers and commits cannot: in packages, and
/// between two releases.  'deploy/revision HASH' names the commit.
/// Builds of one physics revision give the same bits for the same scene, poses and state; others
/// may not.
extern const char* const kPhysicsRevision;
/// Builds of one scenes revision make the same bytes of the same scene file and meshes.
extern const char* const kScenesRevision;

}  // namespace palpate
