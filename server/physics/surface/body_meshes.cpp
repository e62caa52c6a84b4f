#include "server/physics/surface/body_meshes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/error.h"
#include "common/math/solid_angle.h"

namespace palpate {
namespace {

/// Leaves that list each triangle of a body's mesh.
class LeavesOfTriangle {
 public:
  LeavesOfTriangle(const SphereTree& tree, std::size_t triangles)
      : tree_(tree), begin_(triangles + 1, 0) {
    for (std::uint32_t t : tree.leaf_triangle) ++begin_[t + 1];
    for (std::size_t t = 0; t < triangles; ++t) begin_[t + 1] += begin_[t];
    leaf_.resize(tree.leaf_triangle.size());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (std::uint32_t leaf = 0; leaf + 1 < tree.leaf_triangle_begin.size(); ++leaf) {
      for (std::uint32_t i = tree.leaf_triangle_begin[leaf]; i < tree.leaf_triangle_begin[leaf + 1];
           ++i) {
        leaf_[next[tree.leaf_triangle[i]]++] = leaf;
      }
    }
  }

  std::uint32_t Nearest(std::uint32_t triangle, const Vec3& p) const {
    std::uint32_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = begin_[triangle]; i < begin_[triangle + 1]; ++i) {
      const std::uint32_t leaf = leaf_[i];
      const Vec3 c(tree_.leaf_x[leaf], tree_.leaf_y[leaf], tree_.leaf_z[leaf]);
      const double distance = (p - c).norm() - tree_.leaf_radius[leaf];
      if (distance < least) {
        least = distance;
        nearest = leaf;
      }
    }
    return nearest;
  }

 private:
  const SphereTree& tree_;
  std::vector<std::uint32_t> begin_, leaf_;
};

}  // namespace

bool IsFeltByMesh(const PlacedTree& object) {
  return std::none_of(object.materials.begin(), object.materials.end(), [](const Material& m) {
    return std::isfinite(m.stiffness) || std::isfinite(m.hardness);
  });
}

std::unique_ptr<const ObjectMeshes> ObjectMeshes::Make(std::span<const PlacedTree> objects) {
  std::vector<PlacedMesh> placed;
  std::vector<const PlacedTree*> of;
  std::vector<std::int32_t> first_leaf;
  std::int32_t leaves = 0;
  for (const PlacedTree& object : objects) {
    const std::int32_t first = leaves;
    leaves += static_cast<std::int32_t>(object.tree->leaves());
    if (!IsFeltByMesh(object)) continue;
    if (object.mesh == nullptr || object.mesh->triangles.empty() ||
        object.tree->leaf_triangle.empty()) {
      throw Error(
          "surface contact: an object has no mesh; give it one, or use \"contact\": \"spheres\"");
    }
    placed.push_back({object.mesh, object.X_WB});
    of.push_back(&object);
    first_leaf.push_back(first);
  }
  if (placed.empty()) return nullptr;
  return std::unique_ptr<const ObjectMeshes>(new ObjectMeshes(placed, of, first_leaf));
}

ObjectMeshes::ObjectMeshes(std::span<const PlacedMesh> placed,
                           std::span<const PlacedTree* const> object,
                           std::span<const std::int32_t> first_leaf)
    : meshes_(ContactMesh(placed)) {
  std::vector<LeavesOfTriangle> leaves;
  for (const PlacedTree* of : object) {
    leaves.emplace_back(*of->tree, of->mesh->triangles.size());
  }
  boxes_.resize(object.size());
  for (const ContactMesh::Triangle& t : meshes_.mesh.triangles()) {
    for (std::uint32_t v : t.vertex) boxes_[t.body].extend(meshes_.mesh.vertices()[v]);
    const TriangleMesh& mesh = *object[t.body]->mesh;
    Vec3 middle = Vec3::Zero();
    for (std::uint32_t v : mesh.triangles[t.source]) middle += mesh.vertices[v] / 3.0;
    leaf_.push_back(first_leaf[t.body] +
                    static_cast<std::int32_t>(leaves[t.body].Nearest(t.source, middle)));
  }
}

bool ObjectMeshes::Hold(const Vec3& p_W) const {
  std::vector<double> angle(boxes_.size(), 0.0);
  for (std::size_t t = 0; t < meshes_.mesh.triangles().size(); ++t) {
    const std::uint32_t body = meshes_.mesh.triangles()[t].body;
    if (!boxes_[body].contains(p_W)) continue;
    angle[body] += SolidAngle(meshes_.mesh.Corner(t, 0) - p_W, meshes_.mesh.Corner(t, 1) - p_W,
                              meshes_.mesh.Corner(t, 2) - p_W);
  }
  return std::ranges::any_of(angle, [](double a) { return a > 2.0 * M_PI; });
}

std::unique_ptr<const MeshWithTree> MakeToolMesh(const TriangleMesh* mesh, const SphereTree& tree,
                                                 const Vec3& reference) {
  if (tree.leaves() == 1) {
    return std::make_unique<const MeshWithTree>(ContactMesh::Point(), tree.leaf_radius[0]);
  }
  if (mesh == nullptr || mesh->triangles.empty()) {
    throw Error(
        "surface contact: the tool has no mesh; give it one, or use \"contact\": \"spheres\"");
  }
  const PlacedMesh placed{mesh, Pose{-reference, Quat::Identity()}};
  return std::make_unique<const MeshWithTree>(ContactMesh(std::span(&placed, 1)));
}

}  // namespace palpate
