#include "server/physics/tree/sphere_tree_query.h"

#include <cmath>
#include <limits>
#include <numeric>

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

/// Puts a ball into a lane: the centre rounded to float, the radius grown by what that moved it and
/// by the test's margin, and rounded up.
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

Ball LaneBall(const SpherePacket& packet, int lane) {
  return {Vec3(packet.x[lane], packet.y[lane], packet.z[lane]), packet.radius[lane]};
}

/// A ball around balls: centre of their bounding box.  Only for the few levels over the objects.
Ball Around(std::span<const Ball> balls) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (const Ball& ball : balls) {
    low = low.cwiseMin((ball.center.array() - ball.radius).matrix());
    high = high.cwiseMax((ball.center.array() + ball.radius).matrix());
  }
  Ball around{0.5 * (low + high), 0.0};
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

/// Radius of the ball of each lane of a tree's packets, about the lane's centre, that holds what is
/// left of the leaves below it; 0 where nothing is.
template <class RadiusOf>
std::vector<double> RadiiOfRest(const SphereTree& tree, const RadiusOf& radius_of) {
  std::vector<double> radius(kTreeArity * tree.packets.size(), 0.0);
  std::vector<std::vector<std::size_t>> below(tree.leaves());  // leaves of each node
  for (std::size_t i = 0; i < tree.leaves(); ++i) {
    if (radius_of(i) > 0.0) below[i] = {i};
  }
  for (int l = tree.levels() - 1; l >= 0; --l) {
    std::vector<std::vector<std::size_t>> here;
    for (std::size_t i = 0; i < tree.level(l).size(); ++i) {
      const SpherePacket& in = tree.level(l)[i];
      const std::size_t first_lane =
          kTreeArity * (static_cast<std::size_t>(tree.level_begin[l]) + i);
      std::vector<std::size_t>& all = here.emplace_back();
      for (int lane = 0; lane < kTreeArity; ++lane) {
        if (in.child[lane] < 0) continue;
        const Vec3 centre = LaneBall(in, lane).center;
        double& r = radius[first_lane + static_cast<std::size_t>(lane)];
        for (std::size_t leaf : below[static_cast<std::size_t>(in.child[lane])]) {
          r = std::max(r, (LeafCentre(tree, leaf) - centre).norm() + radius_of(leaf));
          all.push_back(leaf);
        }
      }
    }
    below = std::move(here);
  }
  return radius;
}

}  // namespace

ObjectForest::ObjectForest(std::span<const PlacedTree> objects, RadiusOf radius_of) {
  if (objects.empty()) throw Error("scene: no object; a scene needs at least one to feel");
  int deepest = 0;
  for (const PlacedTree& object : objects) {
    CheckTree(*object.tree);
    deepest = std::max(deepest, object.tree->levels());
  }
  // Levels over the objects: level l holds at most 8^(l+1) nodes.
  int top_levels = 0;
  for (std::size_t reach = 1; reach < objects.size(); reach *= kTreeArity) ++top_levels;

  // The objects' own levels, from the bottom up; a shallower tree gets single-lane packets on top.
  std::vector<std::vector<SpherePacket>> level(static_cast<std::size_t>(top_levels + deepest));
  std::vector<Ball> roots;
  for (const PlacedTree& object : objects) {
    const SphereTree& tree = *object.tree;
    const auto leaf_radius = [&](std::size_t i) {
      const double own = tree.leaf_radius[i];
      return radius_of != nullptr ? radius_of(object, own) : own;
    };
    bool whole = true;
    first_leaf_.push_back(leaf_count());
    for (std::size_t i = 0; i < tree.leaves(); ++i) {
      const Vec3 c = object.X_WB * LeafCentre(tree, i);
      leaves_.push_back({c.x(), c.y(), c.z(), leaf_radius(i)});
      any_ = any_ || leaf_radius(i) > 0.0;
      whole = whole && leaf_radius(i) == tree.leaf_radius[i];
    }
    AddMaterials(object);
    const int chain = deepest - tree.levels();
    const std::vector<double> radius =
        whole ? std::vector<double>() : RadiiOfRest(tree, leaf_radius);
    std::vector<Ball> top;
    for (int l = 0; l < tree.levels(); ++l) {
      auto& out = level[static_cast<std::size_t>(top_levels + chain + l)];
      const bool last = l + 1 == tree.levels();
      const std::int32_t child_offset =
          last ? first_leaf_.back()
               : static_cast<std::int32_t>(
                     level[static_cast<std::size_t>(top_levels + chain + l + 1)].size());
      for (std::size_t i = 0; i < tree.level(l).size(); ++i) {
        const SpherePacket& in = tree.level(l)[i];
        const std::size_t first_lane =
            kTreeArity * (static_cast<std::size_t>(tree.level_begin[l]) + i);
        SpherePacket packet = EmptyPacket();
        for (int lane = 0; lane < kTreeArity; ++lane) {
          if (in.child[lane] < 0) continue;
          Ball ball = LaneBall(in, lane);
          if (last) {
            const auto leaf = static_cast<std::size_t>(in.child[lane]);
            ball = {LeafCentre(tree, leaf), leaf_radius(leaf)};
          }
          ball.center = object.X_WB * ball.center;
          if (l == 0) top.push_back(ball);
          if (!whole) ball.radius = radius[first_lane + static_cast<std::size_t>(lane)];
          if (ball.radius == 0.0) continue;
          SetLane(packet, lane, ball, child_offset + in.child[lane]);
        }
        out.push_back(packet);
      }
    }
    const Ball root = Around(top);
    for (int l = chain - 1; l >= 0; --l) {
      auto& out = level[static_cast<std::size_t>(top_levels + l)];
      SpherePacket packet = EmptyPacket();
      SetLane(
          packet, 0, root,
          static_cast<std::int32_t>(level[static_cast<std::size_t>(top_levels + l + 1)].size()) -
              1);
      out.push_back(packet);
    }
    roots.push_back(root);
  }
  // The levels over them: objects in the scene's order, eight to a packet.
  for (int l = top_levels - 1; l >= 0; --l) {
    std::vector<Ball> parents;
    for (std::size_t i = 0; i < roots.size(); i += kTreeArity) {
      const std::size_t n = std::min<std::size_t>(kTreeArity, roots.size() - i);
      SpherePacket packet = EmptyPacket();
      for (std::size_t lane = 0; lane < n; ++lane) {
        SetLane(packet, static_cast<int>(lane), roots[i + lane],
                static_cast<std::int32_t>(i + lane));
      }
      level[static_cast<std::size_t>(l)].push_back(packet);
      parents.push_back(Around(std::span(roots).subspan(i, n)));
    }
    roots = std::move(parents);
  }
  levels_.level_begin.push_back(0);
  for (const auto& packets : level) {
    levels_.packets.insert(levels_.packets.end(), packets.begin(), packets.end());
    levels_.level_begin.push_back(static_cast<std::int32_t>(levels_.packets.size()));
  }
  const Ball all = Around(roots);
  center_ = all.center;
  radius_ = all.radius;
  above_ = EmptyPacket();
  SetLane(above_, 0, all, 0);
}

void ObjectForest::AddMaterials(const PlacedTree& object) {
  const std::size_t first = materials_.size();
  if (object.materials.empty()) {
    materials_.push_back(Material{});
  } else {
    materials_.insert(materials_.end(), object.materials.begin(), object.materials.end());
  }
  const std::size_t leaves = object.tree->leaves();
  if (!object.leaf_material.empty() && object.leaf_material.size() != leaves) {
    throw Error("materials: " + std::to_string(object.leaf_material.size()) + " are given for " +
                std::to_string(leaves) + " leaves; give one a leaf, or none");
  }
  for (std::size_t i = 0; i < leaves; ++i) {
    const std::size_t own = object.leaf_material.empty() ? 0 : object.leaf_material[i];
    if (first + own >= materials_.size()) {
      throw Error("materials: leaf " + std::to_string(i) + " is of material " +
                  std::to_string(own) + ", which is not in the list");
    }
    leaf_material_.push_back(static_cast<std::uint32_t>(first + own));
  }
}

int ObjectForest::ObjectOf(int leaf) const {
  return static_cast<int>(std::upper_bound(first_leaf_.begin(), first_leaf_.end(), leaf) -
                          first_leaf_.begin()) -
         1;
}

Vec3 ToolTree::ReferenceOf(const SphereTree& tree) {
  return tree.leaves() == 1 ? LeafCentre(tree, 0) : tree.centroid;
}

ToolTree::ToolTree(const SphereTree& tree, double world_extent, const Vec3& reference)
    : reference_(reference) {
  CheckTree(tree);
  for (std::size_t i = 0; i < tree.leaves(); ++i) {
    const Vec3 l = LeafCentre(tree, i) - reference_;
    leaves_.push_back({l.x(), l.y(), l.z(), tree.leaf_radius[i]});
    max_lever_ = std::max(max_lever_, l.norm());
    reach_ = std::max(reach_, l.norm() + tree.leaf_radius[i]);
  }
  // What float rounding of the pose and of the rotated centre can move a sphere by, near the
  // objects.
  const double rounding = limits::kPoseMargin * (world_extent + 2.0 * reach_);
  // The longest lever below each node, from the leaves up.
  levels_.packets.assign(tree.packets.size(), EmptyToolPacket());
  levels_.level_begin = tree.level_begin;
  std::vector<double> below;
  for (int l = tree.levels() - 1; l >= 0; --l) {
    const bool last = l + 1 == tree.levels();
    std::vector<double> here;
    for (std::size_t i = 0; i < tree.level(l).size(); ++i) {
      const SpherePacket& in = tree.level(l)[i];
      ToolPacket& out = levels_.packets[static_cast<std::size_t>(tree.level_begin[l]) + i];
      double longest = 0.0;
      for (int lane = 0; lane < kTreeArity; ++lane) {
        if (in.child[lane] < 0) continue;
        const auto child = static_cast<std::size_t>(in.child[lane]);
        Ball ball =
            last ? Ball{LeafCentre(tree, child), tree.leaf_radius[child]} : LaneBall(in, lane);
        ball.center -= reference_;
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
  above_ = EmptyToolPacket();
  SetLane(above_.sphere, 0, {Vec3::Zero(), reach_ + rounding}, 0);
  above_.lever[0] = LeverUp(max_lever_);
}

PairQuery::PairQuery(const ToolTree& tool, const ObjectForest& objects) {
  const PacketLevels<ToolPacket>& t = tool.levels();
  const PacketLevels<SpherePacket>& o = objects.levels();
  const int depth = std::max(t.levels(), o.levels());
  const int t_pad = depth - t.levels(), o_pad = depth - o.levels();
  world_.resize(t.packets.size() + 1);
  stamps_.assign(t.packets.size() + 1, 0u);
  lists_.resize(static_cast<std::size_t>(depth) * kMaxBatch);
  for (int l = 0; l < depth; ++l) {
    const std::size_t t_begin =
        l < t_pad ? t.packets.size() : static_cast<std::size_t>(t.level_begin[l - t_pad]);
    LevelView view{};
    view.tool = l < t_pad ? &tool.above() : t.packets.data() + t_begin;
    view.tool_world = world_.data() + t_begin;
    view.tool_stamp = stamps_.data() + t_begin;
    view.object = l < o_pad ? &objects.above() : o.packets.data() + o.level_begin[l - o_pad];
    views_.push_back(view);
  }
}

}  // namespace palpate
