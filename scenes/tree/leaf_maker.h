#pragma once

#include <cstddef>
#include <vector>

#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/surface_samples.h"
#include "scenes/progress.h"
#include "scenes/scene.h"
#include "scenes/tree/sphere.h"
#include "scenes/tree/tree_mode.h"

namespace palpate {

/// A closed solid, with what all that fill it with balls, or share it out among them, ask of it.
struct SampledSolid {
  /// @param solid   closed as far as it can be (SolidOf, mesh_solid.h); must outlive this.
  /// @param leaves  how many balls are to stand for it.
  /// Throws Error where InspectMesh refuses the mesh.
  SampledSolid(const TriangleMesh& solid, std::size_t leaves);
  SampledSolid(const SampledSolid&) = delete;
  SampledSolid& operator=(const SampledSolid&) = delete;

  const TriangleMesh& mesh;
  const MeshReport report;
  const MeshQuery query;
  const std::vector<SurfaceSample> samples;  ///< five a leaf, and 2,000 at least
};

/// The leaves of a sphere tree [m]: exactly `count` of them, or for TreeMode::kOctree at most.  The
/// one place where a mode is turned into balls: whoever has another way to make them adds a
/// TreeMode, and calls it here.
/// Set-up only.  Deterministic: equal inputs, equal bits.
/// @param solid     made for as many leaves.
/// @param count     at least 1.
/// @param progress  told fractions from 0.1 to 0.8: what comes before and after is the caller's.
/// Throws Error where the solid encloses nothing.
std::vector<Sphere> MakeLeaves(const SampledSolid& solid, std::size_t count, TreeMode mode,
                               const Progress& progress = {});

}  // namespace palpate
