#include "scenes/leaf_paint.h"

#include <algorithm>
#include <string>
#include <string_view>

#include "common/error.h"
#include "common/json/json_file.h"
#include "common/text/nearest_word.h"
#include "scenes/mesh/hidden_surface.h"
#include "scenes/mesh/triangle.h"

namespace palpate {
namespace {

using LeafSet = std::vector<bool>;

Vec3 CentreOf(const SphereTree& tree, std::size_t leaf) {
  return {tree.leaf_x[leaf], tree.leaf_y[leaf], tree.leaf_z[leaf]};
}

/// Returns the area that each leaf represents [m^2]; leaves that have a triangle share it evenly.
/// @param counts  returns whether a triangle counts for a leaf.
template <class Counts>
std::vector<double> LeafAreas(const Body& body, Counts counts) {
  const SphereTree& tree = body.tree;
  std::vector<int> owners(body.mesh.triangles.size(), 0);
  for (std::uint32_t t : tree.leaf_triangle) ++owners[t];
  std::vector<double> areas(tree.leaves(), 0.0);
  for (std::size_t leaf = 0; leaf < tree.leaves(); ++leaf) {
    for (auto k = tree.leaf_triangle_begin[leaf]; k < tree.leaf_triangle_begin[leaf + 1]; ++k) {
      const std::uint32_t t = tree.leaf_triangle[k];
      if (!counts(leaf, t)) continue;
      areas[leaf] += TriangleOf(body.mesh, t).Area() / owners[t];
    }
  }
  return areas;
}

[[noreturn]] void RefuseUnknownPart(const RegionDescription& region,
                                    const std::vector<MeshGroup>& groups) {
  std::vector<std::string_view> names;
  for (const MeshGroup& group : groups) {
    if (std::ranges::find(names, group.name) == names.end()) names.push_back(group.name);
  }
  std::string message = region.where + ".group: the mesh has no part \"" + region.group + "\"" +
                        DidYouMean(region.group, names);
  if (names.empty()) {
    throw Error(message + "; its file has no named parts; give a box or a sphere");
  }
  message += " It has:";
  for (std::string_view name : names) message.append(" \"").append(name).append("\",");
  message.back() = '.';
  throw Error(message);
}

/// The exposed triangles of the leaves.  Surface inside another part of the mesh cannot be touched,
/// so it decides no material.  Needed only for bodies with several materials or with layers.
class Exposed {
 public:
  explicit Exposed(const Body& body) : body_(body), hidden_(body.mesh) {}

  bool operator()(std::size_t leaf, std::uint32_t triangle) const {
    return !hidden_.NearestTo(triangle, CentreOf(body_.tree, leaf));
  }

 private:
  const Body& body_;
  HiddenSurface hidden_;
};

/// Returns the leaves whose exposed surface belongs mostly to the part.
LeafSet LeavesOfGroup(const RegionDescription& region, const std::vector<MeshGroup>& groups,
                      const Body& body, const std::vector<double>& areas, const Exposed& exposed) {
  std::vector<bool> named(body.mesh.triangles.size(), false);
  bool known = false;
  for (const MeshGroup& group : groups) {
    if (group.name != region.group) continue;
    known = true;
    std::fill(named.begin() + group.begin, named.begin() + group.end, true);
  }
  if (!known) RefuseUnknownPart(region, groups);
  const std::vector<double> ours = LeafAreas(
      body, [&](std::size_t leaf, std::uint32_t t) { return named[t] && exposed(leaf, t); });
  LeafSet leaves(areas.size());
  for (std::size_t i = 0; i < areas.size(); ++i) leaves[i] = ours[i] > 0.5 * areas[i];
  return leaves;
}

LeafSet LeavesOf(const RegionDescription& region, const std::vector<MeshGroup>& groups,
                 const Body& body, const std::vector<double>& areas, const Exposed& exposed) {
  if (region.kind == RegionDescription::Kind::kGroup) {
    return LeavesOfGroup(region, groups, body, areas, exposed);
  }
  LeafSet leaves(body.tree.leaves());
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const Vec3 centre = CentreOf(body.tree, i);
    leaves[i] = region.kind == RegionDescription::Kind::kBox
                    ? region.box.contains(centre)
                    : (centre - region.ball.centre).norm() <= region.ball.radius;
  }
  return leaves;
}

/// Returns the material of the leaves that have `index` in body.leaf_material.
Material Resolve(const MaterialDescription& description, std::uint8_t index, const Body& body,
                 const std::vector<double>& areas) {
  Material material = description.material;
  if (description.youngs_modulus <= 0.0) return material;
  double area = 0.0;
  std::size_t bearing = 0;  // leaves with surface; those that fill the inside have none
  for (std::size_t i = 0; i < areas.size(); ++i) {
    const bool ours = (body.leaf_material.empty() ? 0 : body.leaf_material[i]) == index;
    if (!ours || areas[i] <= 0.0) continue;
    area += areas[i];
    ++bearing;
  }
  // Later regions may have painted over all leaves of this material.
  if (bearing == 0) return material;
  material.stiffness =
      description.youngs_modulus * (area / static_cast<double>(bearing)) / description.thickness;
  return material;
}

}  // namespace

void PaintLeaves(const BodyDescription& description, const std::vector<MeshGroup>& groups,
                 Body& body) {
  body.materials = {description.material.material};
  if (description.grid) {
    // Materials belong to its points, not to its leaves.
    body.grid.emplace().spacing = *description.grid;
    for (const RegionDescription& region : description.regions) {
      const auto material = static_cast<std::uint8_t>(body.materials.size());
      const bool ball = region.kind == RegionDescription::Kind::kSphere;
      body.grid->regions.push_back({ball ? region.ball.centre : region.box.min(),
                                    region.box.max(),
                                    ball ? region.ball.radius : 0.0,
                                    material,
                                    {}});
      body.materials.push_back(region.material.material);
    }
    return;
  }
  if (description.regions.empty() && description.material.youngs_modulus <= 0.0) return;
  const Exposed exposed(body);
  const std::vector<double> areas = LeafAreas(body, exposed);
  if (!description.regions.empty()) body.leaf_material.assign(body.tree.leaves(), 0);
  std::vector<const MaterialDescription*> written{&description.material};
  for (const RegionDescription& region : description.regions) {
    const LeafSet leaves = LeavesOf(region, groups, body, areas, exposed);
    if (std::find(leaves.begin(), leaves.end(), true) == leaves.end()) {
      throw Error(
          region.where + ": covers no leaf of \"" + body.name +
          (region.kind == RegionDescription::Kind::kGroup
               ? "\"; the part may lie entirely inside others, where nothing can touch it (see "
                 "'palpate-scene check'); drop the region, or give the body more leaves"
               : "\"; move or enlarge it (its frame is the body's, in mm), or give the body more "
                 "leaves"));
    }
    const auto index = static_cast<std::uint8_t>(written.size());
    written.push_back(&region.material);
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      if (leaves[i]) body.leaf_material[i] = index;
    }
  }
  body.materials.clear();
  for (std::size_t m = 0; m < written.size(); ++m) {
    body.materials.push_back(Resolve(*written[m], static_cast<std::uint8_t>(m), body, areas));
  }
}

}  // namespace palpate
