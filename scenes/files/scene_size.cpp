#include "scenes/files/scene_size.h"

#include "common/error.h"

namespace palpate {
namespace {

template <class T>
std::size_t Bytes(const std::vector<T>& items) {
  return items.size() * sizeof(T);
}

}  // namespace

void SceneSize::Add(const std::string& body, const TriangleMesh& mesh, const SphereTree& tree) {
  bytes_ += Bytes(mesh.vertices) + Bytes(mesh.triangles) + 4 * Bytes(tree.leaf_radius) +
            Bytes(tree.packets) + Bytes(tree.leaf_triangle) + Bytes(tree.leaf_triangle_begin);
  if (bytes_ <= kMaxSceneBytes) return;
  throw Error("with body \"" + body + "\" the scene's meshes and trees take more than " +
              std::to_string(kMaxSceneBytes >> 20) +
              " MB; give it fewer bodies, or bodies of fewer triangles and leaves");
}

}  // namespace palpate
