#include "server/physics/surface/body_surfaces.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace palpate {
namespace {

template <class T>
void Append(const std::vector<T>& from, std::vector<T>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

std::unique_ptr<const ObjectForest> MakeForest(const std::vector<const SphereTree*>& trees) {
  std::vector<PlacedTree> placed;
  for (const SphereTree* tree : trees) {
    if (tree->leaves() > 0) placed.push_back({.tree = tree});
  }
  return placed.empty() ? nullptr : std::make_unique<const ObjectForest>(placed);
}

std::unique_ptr<const ToolTree> MakeToolTree(const SphereTree& tree, double world_extent) {
  if (tree.leaves() == 0) return nullptr;
  return std::make_unique<const ToolTree>(tree, world_extent, Vec3::Zero(),
                                          ToolTree::Levers::kToRims);
}

}  // namespace

bool HasSurface(const PlacedTree& object) {
  return std::none_of(object.materials.begin(), object.materials.end(), [](const Material& m) {
    return std::isfinite(m.stiffness) || std::isfinite(m.hardness);
  });
}

ObjectSurfaces::ObjectSurfaces(std::span<const PlacedTree> objects) {
  std::vector<ContactSurface> surfaces;
  surfaces.reserve(objects.size());
  std::uint32_t first_leaf = 0;
  std::vector<const SphereTree*> point_trees, patch_trees, crease_trees;
  for (const PlacedTree& object : objects) {
    const std::uint32_t own_leaf = first_leaf;
    first_leaf += static_cast<std::uint32_t>(object.tree->leaves());
    if (!HasSurface(object)) continue;
    if (object.mesh == nullptr || object.tree->leaf_triangle.empty()) {
      throw Error(
          "surface contact: an object has no mesh; give it one, or use \"contact\": \"spheres\"");
    }
    surfaces.emplace_back(*object.mesh, *object.tree, object.X_WB);
    const ContactSurface& surface = surfaces.back();
    Append(surface.points, points);
    Append(surface.patches, patches);
    Append(surface.discs, discs);
    Append(surface.creases, creases);
    patch_object.resize(patches.size(), static_cast<std::uint32_t>(surfaces.size()));
    for (std::uint32_t leaf : surface.point_leaf) point_leaf.push_back(own_leaf + leaf);
    for (std::uint32_t leaf : surface.patch_leaf) patch_leaf.push_back(own_leaf + leaf);
    for (std::uint32_t leaf : surface.crease_leaf) crease_leaf.push_back(own_leaf + leaf);
    point_trees.push_back(&surface.point_tree);
    patch_trees.push_back(&surface.patch_tree);
    crease_trees.push_back(&surface.crease_tree);
  }
  point_forest = MakeForest(point_trees);
  patch_forest = MakeForest(patch_trees);
  crease_forest = MakeForest(crease_trees);
}

std::uint32_t ObjectSurfaces::LeafOf(NodePair pair) const {
  const auto object = static_cast<std::size_t>(pair.object);
  switch (KindOf(pair)) {
    case RowKind::kPointOnPatch:
      return patch_leaf[object];
    case RowKind::kPatchOnPoint:
      return point_leaf[object];
    case RowKind::kCreases:
    case RowKind::kBallOnCrease:
      return crease_leaf[object];
    case RowKind::kLeaves:
      break;
  }
  return static_cast<std::uint32_t>(pair.object);
}

ToolSurface::ToolSurface(const TriangleMesh* mesh, const SphereTree& tree, const Vec3& reference,
                         double world_extent) {
  if (tree.leaves() == 1) {
    radius = tree.leaf_radius[0];
    SurfacePoint centre{};
    centre.cosine = kFacesAnything;
    points.push_back(centre);
    SphereTree ball = tree;
    ball.leaf_x[0] = ball.leaf_y[0] = ball.leaf_z[0] = 0.0;
    point_tree = MakeToolTree(ball, world_extent);
    crease_tree = MakeToolTree(ball, world_extent);
    return;
  }
  if (mesh == nullptr || tree.leaf_triangle.empty()) {
    throw Error(
        "surface contact: the tool has no mesh; give it one, or use \"contact\": \"spheres\"");
  }
  ContactSurface surface(*mesh, tree, Pose{-reference, Quat::Identity()});
  point_tree = MakeToolTree(surface.point_tree, world_extent);
  patch_tree = MakeToolTree(surface.patch_tree, world_extent);
  crease_tree = MakeToolTree(surface.crease_tree, world_extent);
  for (const SurfacePoint& point : surface.points) {
    max_lever = std::max(max_lever, Vec3(point.x[0], point.x[1], point.x[2]).norm());
  }
  points = std::move(surface.points);
  patches = std::move(surface.patches);
  discs = std::move(surface.discs);
  creases = std::move(surface.creases);
}

}  // namespace palpate
