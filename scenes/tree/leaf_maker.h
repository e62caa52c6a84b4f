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

/// A closed solid with samples and queries, shared by all that fill it with balls or divide
/// it among them.
struct SampledSolid {
  /// @param solid   closed as far as possible (SolidOf, mesh_solid.h); must outlive this.
  /// @param leaves  the number of balls that are to represent it.
  /// Throws Error if InspectMesh refuses the mesh.
  SampledSolid(const TriangleMesh& solid, std::size_t leaves);
  SampledSolid(const SampledSolid&) = delete;
  SampledSolid& operator=(const SampledSolid&) = delete;

  const TriangleMesh& mesh;
  const MeshReport report;
  const MeshQuery query;
  const std::vector<SurfaceSample> samples;  ///< five per leaf, but at least 2,000
};

/// Makes the leaves of a sphere tree [m]: exactly `count`.
/// This is the only place where a mode is turned into balls: to make them in another way, add a
/// TreeMode and call it here.
///
/// Set-up only.  Deterministic: equal inputs, equal bits.
/// @param solid     made for the same number of leaves.
/// @param count     at least 1.
/// @param progress  is told fractions from 0.1 to 0.8; the rest is the caller's.
/// Throws Error if the solid encloses nothing.
std::vector<Sphere> MakeLeaves(const SampledSolid& solid, std::size_t count, TreeMode mode,
                               const Progress& progress = {});

}  // namespace palpate
