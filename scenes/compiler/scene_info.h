#pragma once

#include <string>

#include "scenes/scene.h"

namespace palpate {

/// Returns text for people: features, bodies, materials, and for each level of each tree how
/// densely it is packed and how far it is from the mesh (tree_error.h).  Bodies that share a
/// geometry are measured once.
std::string SceneInfo(const Scene& scene);

}  // namespace palpate
