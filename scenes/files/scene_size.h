#pragma once

#include <cstddef>
#include <string>

#include "scenes/scene.h"

namespace palpate {

/// The most bytes of meshes and trees in a scene's bodies, where each body counts in full.  Many
/// bodies of one geometry make a small file but need much memory in a server, whose contact models
/// take some three times as much again.
inline constexpr std::size_t kMaxSceneBytes = std::size_t{1} << 30;

/// Adds up the sizes of bodies before they are copied.
class SceneSize {
 public:
  /// Throws Error, with the body and the limit, if the sum exceeds it.
  void Add(const std::string& body, const TriangleMesh& mesh, const SphereTree& tree);

 private:
  std::size_t bytes_ = 0;
};

}  // namespace palpate
