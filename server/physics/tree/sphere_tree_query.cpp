#include "server/physics/tree/sphere_tree_query.h"

#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Geometry>

#include "common/error.h"
#include "common/math/float_rounding.h"
#include "server/physics/limits.h"

namespace palpate {
namespace {

SpherePacket EmptyPacket() {
  SpherePacket packet;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < kTreeArity; ++i) {
    packet.x[i] = packet.y[i] = packet.z[i] = packet.radius[i] = nan;
    packet.child[i] = -1;
  }
  return packet;
}

ToolPacket EmptyToolPacket() {
  ToolPacket packet{EmptyPacket(), {}};
  for (float& lever : packet.lever) lever = std::numeric_limits<float>::quiet_NaN();
  return packet;
}

struct Ball {
  Vec3 center;
  double radius;
};

/// Stores a ball in a lane: the centre is rounded to float; the radius grows by that rounding and
/// by the test's margin, and is rounded up.
void SetLane(SpherePacket& packet, int lane, const Ball& ball, std::int32_t child) {
  const Vec3& c = ball.center;
  packet.x[lane] = RoundToFloat(c.x());
  packet.y[lane] = RoundToFloat(c.y());
  packet.z[lane] = RoundToFloat(c.z());
  const Vec3 rounded(packet.x[lane], packet.y[lane], packet.z[lane]);
  const double radius = (ball.radius + (rounded - c).norm()) * (1.0 + limits::kRadiusMargin);
  packet.radius[lane] =
      std::nextafter(RoundToFloat(radius), std::numeric_limits<float>::infinity());
  packet.child[lane] = child;
}

float LeverUp(double lever) {
  return std::nextafter(RoundToFloat(lever * (1.0 + limits::kRadiusMargin)),
                        std::numeric_limits<float>::infinity());
}

/// Returns a ball around balls, at the centre of their bounding box.  Used only for the few
/// levels over the objects.
Ball Around(std::span<const Ball> balls) {
  Eigen::AlignedBox3d box;
  for (const Ball& ball : balls) {
    box.extend((ball.center.array() - ball.radius).matrix());
    box.extend((ball.center.array() + ball.radius).matrix());
  }
  Ball around{0.5 * (box.min() + box.max()), 0.0};
  for (const Ball& ball : balls) {
    around.radius = std::max(around.radius, (ball.center - around.center).norm() + ball.radius);
  }
  return around;
}

void CheckTree(const SphereTree& tree) {
  if (tree.leaves() == 0 || tree.levels() < 1) {
    throw Error("sphere tree: no leaves; build it with at least 1");
  }
  for (std::size_t i = 0; i < tree.leaves(); ++i) {
    const double sum = tree.leaf_x[i] + tree.leaf_y[i] + tree.leaf_z[i] + tree.leaf_radius[i];
    if (!std::isfinite(sum) || !(tree.leaf_radius[i] > 0.0)) {
      throw Error("sphere tree: leaf " + std::to_string(i) +
                  " is not a finite ball; build the tree again from its mesh");
    }
  }
}

Vec3 LeafCentre(const SphereTree& tree, std::size_t i) {
  return {tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]};
}

/// Returns the ball of a lane; at the last level, which lists leaves, the leaf's own.
Ball BallOf(const SphereTree& tree, int level, const SpherePacket& packet, int lane) {
  if (level + 1 < tree.levels()) {
    return {Vec3(packet.x[lane], packet.y[lane], packet.z[lane]), packet.radius[lane]};
  }
  const auto leaf = static_cast<std::size_t>(packet.child[lane]);
  return {LeafCentre(tree, leaf), tree.leaf_radius[leaf]};
}

using Level = std::vector<SpherePacket>;

/// Adds an object's packets to the levels that objects have in a forest; a shallower tree gets
/// packets of one lane on top.  Returns a ball around the object.
/// @param touches     if false, no lane leads to its leaves
/// @param first_leaf  number of its first leaf in the forest
Ball AddPackets(const PlacedTree& object, bool touches, int first_leaf, std::span<Level> levels) {
  const SphereTree& tree = *object.tree;
  const std::size_t chain = levels.size() - static_cast<std::size_t>(tree.levels());
  std::vector<Ball> top;
  for (int l = 0; l < tree.levels(); ++l) {
    const std::size_t at = chain + static_cast<std::size_t>(l);
    const int first_child =
        l + 1 == tree.levels() ? first_leaf : static_cast<int>(levels[at + 1].size());
    for (const SpherePacket& in : tree.level(l)) {
      SpherePacket& packet = levels[at].emplace_back(EmptyPacket());
      for (int lane = 0; lane < kTreeArity; ++lane) {
        if (in.child[lane] < 0) continue;
        Ball ball = BallOf(tree, l, in, lane);
        ball.center = object.X_WB * ball.center;
        if (l == 0) top.push_back(ball);
        if (touches) SetLane(packet, lane, ball, first_child + in.child[lane]);
      }
    }
  }
  const Ball root = Around(top);
  for (std::size_t l = chain; l-- > 0;) {
    SetLane(levels[l].emplace_back(EmptyPacket()), 0, root,
            static_cast<std::int32_t>(levels[l + 1].size()) - 1);
  }
  return root;
}

/// Fills the levels over the objects, which stay in the scene's order, eight to a packet.  Returns
/// a ball around all.
Ball AddTop(std::vector<Ball> roots, std::span<Level> levels) {
  for (std::size_t l = levels.size(); l-- > 0;) {
    std::vector<Ball> parents;
    for (std::size_t i = 0; i < roots.size(); i += kTreeArity) {
      const std::size_t n = std::min<std::size_t>(kTreeArity, roots.size() - i);
      SpherePacket& packet = levels[l].emplace_back(EmptyPacket());
      for (std::size_t lane = 0; lane < n; ++lane) {
        SetLane(packet, static_cast<int>(lane), roots[i + lane],
                static_cast<std::int32_t>(i + lane));
      }
      parents.push_back(Around(std::span(roots).subspan(i, n)));
    }
    roots = std::move(parents);
  }
  return Around(roots);
}

}  // namespace

ObjectForest::ObjectForest(std::span<const PlacedTree> objects,
                           bool (*touches)(const PlacedTree&)) {
  if (objects.empty()) throw Error("scene: no object; a scene needs at least one to feel");
  int deepest = 0;
  for (const PlacedTree& object : objects) {
    CheckTree(*object.tree);
    deepest = std::max(deepest, object.tree->levels());
  }
  // Levels over the objects: level l holds at most 8^(l+1) nodes.
  std::size_t top = 0;
  for (std::size_t reach = 1; reach < objects.size(); reach *= kTreeArity) ++top;

  std::vector<Level> packets(top + static_cast<std::size_t>(deepest));
  std::vector<Ball> roots;
  for (const PlacedTree& object : objects) {
    const bool can_touch = touches == nullptr || touches(object);
    any = any || can_touch;
    first_leaf.push_back(static_cast<int>(leaves.size()));
    for (std::size_t i = 0; i < object.tree->leaves(); ++i) {
      const Vec3 c = object.X_WB * LeafCentre(*object.tree, i);
      leaves.push_back({c.x(), c.y(), c.z(), object.tree->leaf_radius[i]});
    }
    AddMaterials(object);
    roots.push_back(
        AddPackets(object, can_touch, first_leaf.back(), std::span(packets).subspan(top)));
  }
  const Ball all = AddTop(std::move(roots), std::span(packets).first(top));
  levels.level_begin.push_back(0);
  for (const Level& level : packets) {
    levels.packets.insert(levels.packets.end(), level.begin(), level.end());
    levels.level_begin.push_back(static_cast<std::int32_t>(levels.packets.size()));
  }
  center = all.center;
  radius = all.radius;
  above = EmptyPacket();
  SetLane(above, 0, all, 0);
}

void ObjectForest::AddMaterials(const PlacedTree& object) {
  const std::size_t first = materials.size();
  if (object.materials.empty()) {
    materials.push_back(Material{});
  } else {
    materials.insert(materials.end(), object.materials.begin(), object.materials.end());
  }
  for (const Material& material : object.materials) {
    if (!(material.stiffness > 0.0)) {
      throw Error("materials: stiffness " + std::to_string(material.stiffness) + " N/m of object " +
                  std::to_string(first_leaf.size() - 1) +
                  "; give a positive number, or none for a rigid material");
    }
  }
  const std::size_t count = object.tree->leaves();
  if (!object.leaf_material.empty() && object.leaf_material.size() != count) {
    throw Error("materials: " + std::to_string(object.leaf_material.size()) + " are given for " +
                std::to_string(count) + " leaves; give one per leaf, or none");
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t own = object.leaf_material.empty() ? 0 : object.leaf_material[i];
    if (first + own >= materials.size()) {
      throw Error("materials: leaf " + std::to_string(i) + " is of material " +
                  std::to_string(own) + ", which is not in the list");
    }
    leaf_material.push_back(static_cast<std::uint32_t>(first + own));
    yields = yields || !std::isinf(materials[first + own].stiffness);
  }
}

ToolTree::ToolTree(const SphereTree& tree, double world_extent) {
  CheckTree(tree);
  reference = tree.leaves() == 1 ? LeafCentre(tree, 0) : tree.centroid;
  for (std::size_t i = 0; i < tree.leaves(); ++i) {
    const Vec3 l = LeafCentre(tree, i) - reference;
    leaves.push_back({l.x(), l.y(), l.z(), tree.leaf_radius[i]});
    max_lever = std::max(max_lever, l.norm());
    reach = std::max(reach, l.norm() + tree.leaf_radius[i]);
  }
  // Upper bound on how far the float rounding of the pose and of the rotated centre moves a
  // sphere near the objects.
  const double rounding = limits::kPoseMargin * (world_extent + 2.0 * reach);
  // The longest lever below each node, from the leaves up.
  levels.packets.assign(tree.packets.size(), EmptyToolPacket());
  levels.level_begin = tree.level_begin;
  std::vector<double> below;
  for (int l = tree.levels() - 1; l >= 0; --l) {
    const bool last = l + 1 == tree.levels();
    std::vector<double> here;
    for (std::size_t i = 0; i < tree.level(l).size(); ++i) {
      const SpherePacket& in = tree.level(l)[i];
      ToolPacket& out = levels.packets[static_cast<std::size_t>(tree.level_begin[l]) + i];
      double longest = 0.0;
      for (int lane = 0; lane < kTreeArity; ++lane) {
        if (in.child[lane] < 0) continue;
        const auto child = static_cast<std::size_t>(in.child[lane]);
        Ball ball = BallOf(tree, l, in, lane);
        ball.center -= reference;
        const double lever = last ? ball.center.norm() : below[child];
        ball.radius += rounding;
        SetLane(out.sphere, lane, ball, in.child[lane]);
        out.lever[lane] = LeverUp(lever);
        longest = std::max(longest, lever);
      }
      here.push_back(longest);
    }
    below = std::move(here);
  }
  above = EmptyToolPacket();
  SetLane(above.sphere, 0, {Vec3::Zero(), reach + rounding}, 0);
  above.lever[0] = LeverUp(max_lever);
}

PairQuery::PairQuery(const ToolTree& tool, const ObjectForest& objects) {
  const PacketLevels<ToolPacket>& t = tool.levels;
  const PacketLevels<SpherePacket>& o = objects.levels;
  const int depth = std::max(t.levels(), o.levels());
  const int t_pad = depth - t.levels(), o_pad = depth - o.levels();
  world_.resize(t.packets.size() + 1);
  stamps_.assign(t.packets.size() + 1, 0u);
  lists_.resize(static_cast<std::size_t>(depth) * kMaxBatch);
  for (int l = 0; l < depth; ++l) {
    const std::size_t t_begin =
        l < t_pad ? t.packets.size() : static_cast<std::size_t>(t.level_begin[l - t_pad]);
    LevelView view{};
    view.tool = l < t_pad ? &tool.above : t.packets.data() + t_begin;
    view.tool_world = world_.data() + t_begin;
    view.tool_stamp = stamps_.data() + t_begin;
    view.object = l < o_pad ? &objects.above : o.packets.data() + o.level_begin[l - o_pad];
    views_.push_back(view);
  }
}

}  // namespace palpate
