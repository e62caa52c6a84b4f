#pragma once

#include <cstdint>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// What is left of a scene's objects as leaves are scraped off: for the server's record, for
/// viewers and for replay, each of which feeds it the same events.  Keeps nothing of the scene but
/// which leaf stands for which triangles.
class SceneRemains {
 public:
  explicit SceneRemains(const Scene& scene);

  /// Takes a leaf of an object away.  Returns the triangles of the object's mesh that go with it:
  /// those that no other leaf which is left stands for.  Leaves and triangles that are gone, or
  /// never were, are none.
  std::vector<std::uint32_t> Remove(std::uint32_t object, std::uint32_t leaf);
  bool leaf_gone(std::uint32_t object, std::uint32_t leaf) const;
  bool triangle_gone(std::uint32_t object, std::uint32_t triangle) const;

 private:
  struct Part {
    std::vector<std::uint32_t> triangle_begin, triangle;  ///< as SphereTree::leaf_triangle
    std::vector<bool> gone;                               ///< by leaf
    std::vector<std::uint32_t> leaves_left;               ///< by triangle: that stand for it
    std::vector<bool> triangle_gone;
  };
  std::vector<Part> parts_;
};

}  // namespace palpate
