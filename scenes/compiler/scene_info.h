#pragma once

#include <cstddef>
#include <string>

#include "scenes/scene.h"

namespace palpate {

/// Options of what palpate-scene info prints in addition to its verdict.
struct InfoOptions {
  std::size_t samples = 10007;  ///< points of each surface; a prime, as other measurements use
  std::string csv, json;        ///< files for the errors of the levels; "-": stdout
};

/// Returns text for people: features, bodies, materials, and for each level of each tree how
/// densely it is packed and how far it is from the mesh (tree_error.h).  Bodies that share a
/// geometry are measured once.  Writes options.csv and options.json.  Throws Error, UsageError.
std::string SceneInfo(const Scene& scene, const InfoOptions& options);

}  // namespace palpate
