#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>

#include "scenes/scene.h"
#include "scenes/sphere.h"
#include "scenes/sphere_tree.h"
#include "scenes/tree_mode.h"

namespace palpate {

/// Names a stage of the work and how much of it is done, 0 to 1.
using Progress = std::function<void(std::string_view stage, double fraction)>;

/// Changes with every change of what the builder makes, so that older cached scenes are built anew.
inline constexpr std::uint32_t kSphereTreeBuilderVersion = 3;

/// Sphere tree of exactly `leaves` leaves over a mesh (chapter 2.2.3).
/// @param mesh  may be open or not manifold, but must be oriented (mesh_orient.h).
/// Deterministic: equal inputs, equal bits.  One thread; 22,332 leaves of the bunny take seconds.
/// Throws Error where InspectMesh refuses the mesh or leaves is 0.
SphereTree BuildSphereTree(const TriangleMesh& mesh, std::size_t leaves,
                           const Progress& progress = {}, TreeMode mode = TreeMode::kInside);

/// Tree of one leaf that is exactly `ball`: a spherical tool.
SphereTree SingleSphereTree(const TriangleMesh& mesh, const Sphere& ball);

}  // namespace palpate
