#pragma once

#include <cstddef>
#include <string>

#include "scenes/scene.h"

namespace palpate {

/// The most that the bodies of a scene may hold of meshes and trees, each counted as often as it
/// stands there: many bodies of one geometry take little of a file and much of a server, whose
/// models of contact take some three times as much again.
inline constexpr std::size_t kMaxSceneBytes = std::size_t{1} << 30;

/// Adds up bodies before they are copied.
class SceneSize {
 public:
  /// Throws Error, which names the body and the bound, where it is too much.
  void Add(const std::string& body, const TriangleMesh& mesh, const SphereTree& tree);

 private:
  std::size_t bytes_ = 0;
};

}  // namespace palpate
