#include "scenes/scene_remains.h"

namespace palpate {

SceneRemains::SceneRemains(const Scene& scene) {
  for (const Body& object : scene.objects) {
    Part part{object.tree.leaf_triangle_begin, object.tree.leaf_triangle,
              std::vector<bool>(object.tree.leaves()),
              std::vector<std::uint32_t>(object.mesh.triangles.size()),
              std::vector<bool>(object.mesh.triangles.size())};
    // Trees without triangles stand for themselves.
    part.triangle_begin.resize(object.tree.leaves() + 1, 0);
    for (const std::uint32_t triangle : part.triangle) ++part.leaves_left.at(triangle);
    parts_.push_back(std::move(part));
  }
}

std::vector<std::uint32_t> SceneRemains::Remove(std::uint32_t object, std::uint32_t leaf) {
  std::vector<std::uint32_t> triangles;
  if (object >= parts_.size() || leaf >= parts_[object].gone.size()) return triangles;
  Part& part = parts_[object];
  if (part.gone[leaf]) return triangles;
  part.gone[leaf] = true;
  for (std::uint32_t i = part.triangle_begin[leaf]; i < part.triangle_begin[leaf + 1]; ++i) {
    const std::uint32_t triangle = part.triangle[i];
    if (--part.leaves_left[triangle] != 0) continue;
    part.triangle_gone[triangle] = true;
    triangles.push_back(triangle);
  }
  return triangles;
}

bool SceneRemains::leaf_gone(std::uint32_t object, std::uint32_t leaf) const {
  return object < parts_.size() && leaf < parts_[object].gone.size() && parts_[object].gone[leaf];
}

bool SceneRemains::triangle_gone(std::uint32_t object, std::uint32_t triangle) const {
  return object < parts_.size() && triangle < parts_[object].triangle_gone.size() &&
         parts_[object].triangle_gone[triangle];
}

}  // namespace palpate
