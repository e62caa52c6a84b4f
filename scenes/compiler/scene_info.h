#pragma once

#include <cstddef>
#include <string>

#include "scenes/scene.h"

namespace palpate {

/// What palpate-scene info says of a scene beside its verdict.
struct InfoOptions {
  std::size_t samples =
      10007;              ///< points of each surface; a prime, as those that others measure by
  std::string csv, json;  ///< files that get the errors of the levels, too; "-": stdout
};

/// Text for people: features, bodies, materials, and of each level of each tree how it is packed
/// and how far it is from the mesh (tree_error.h).  Bodies that share a geometry are measured once.
/// Writes options.csv and options.json.  Throws Error, UsageError.
std::string SceneInfo(const Scene& scene, const InfoOptions& options);

}  // namespace palpate
