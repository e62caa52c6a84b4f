#include "server/physics/surface_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "common/math/float_rounding.h"

namespace palpate {
namespace {

using Range = std::span<std::uint32_t>;

SpherePacket EmptyPacket() {
  SpherePacket packet;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int lane = 0; lane < kTreeArity; ++lane) {
    packet.x[lane] = packet.y[lane] = packet.z[lane] = packet.radius[lane] = nan;
    packet.child[lane] = -1;
  }
  return packet;
}

class SurfaceTreeBuilder {
 public:
  SurfaceTreeBuilder(const SphereTree& spheres, const Pose& X_FB,
                     const std::vector<SurfacePiece>& pieces, std::vector<std::uint32_t>& order)
      : spheres_(spheres), X_FB_(X_FB), pieces_(pieces), order_(order) {
    order_.resize(pieces.size());
    std::iota(order_.begin(), order_.end(), 0u);
    if (pieces.empty()) return;
    std::stable_sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
      return pieces[a].leaf < pieces[b].leaf;
    });
    AddBelowLeaves();
    AddSphereLevels();
    for (std::size_t l = 0; l < packets_.size(); ++l) {
      tree_.level_begin.push_back(static_cast<std::int32_t>(tree_.packets.size()));
      tree_.packets.insert(tree_.packets.end(), packets_[l].begin(), packets_[l].end());
    }
    tree_.level_begin.push_back(static_cast<std::int32_t>(tree_.packets.size()));
  }

  SphereTree Take() { return std::move(tree_); }

 private:
  Vec3 LeafCentre(std::uint32_t leaf) const {
    return X_FB_ * Vec3(spheres_.leaf_x[leaf], spheres_.leaf_y[leaf], spheres_.leaf_z[leaf]);
  }

  double RadiusAbout(const Vec3& centre, std::span<const std::uint32_t> range) const {
    double radius = 0.0;
    for (std::uint32_t i : range) {
      for (const Vec3& corner : pieces_[i].corner) {
        radius = std::max(radius, (corner - centre).norm() + pieces_[i].slack);
      }
    }
    return radius;
  }

  void SetLane(SpherePacket& packet, std::size_t lane, const Vec3& centre,
               std::span<const std::uint32_t> range, std::int32_t child) const {
    packet.x[lane] = RoundToFloat(centre.x());
    packet.y[lane] = RoundToFloat(centre.y());
    packet.z[lane] = RoundToFloat(centre.z());
    const Vec3 rounded(packet.x[lane], packet.y[lane], packet.z[lane]);
    packet.radius[lane] =
        std::nextafter(RoundToFloat(RadiusAbout(centre, range) + (rounded - centre).norm()),
                       std::numeric_limits<float>::infinity());
    packet.child[lane] = child;
  }

  /// Centre of the ball of a few pieces of one leaf.
  Vec3 CentreOf(std::span<const std::uint32_t> range) const {
    Vec3 middle = Vec3::Zero(), outward = Vec3::Zero();
    for (std::uint32_t i : range) {
      for (const Vec3& corner : pieces_[i].corner) middle += corner;
      outward += pieces_[i].outward;
    }
    middle /= 3.0 * static_cast<double>(range.size());
    const double length = outward.norm();
    if (!(length > 0.7 * static_cast<double>(range.size()))) return middle;
    const Vec3 behind = LeafCentre(pieces_[range.front()].leaf);
    const double front = RadiusAbout(behind, range) - (middle - behind).dot(outward) / length;
    return front < RadiusAbout(middle, range) ? behind : middle;
  }

  /// The first `count` of a range are to lie on one side of the rest.
  void Divide(Range range, std::size_t count) const {
    const auto middle = [&](std::uint32_t i) -> Vec3 {
      return pieces_[i].corner[0] + pieces_[i].corner[1] + pieces_[i].corner[2];
    };
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (std::uint32_t i : range) {
      low = low.cwiseMin(middle(i));
      high = high.cwiseMax(middle(i));
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    std::nth_element(range.begin(), range.begin() + static_cast<std::ptrdiff_t>(count), range.end(),
                     [&](std::uint32_t a, std::uint32_t b) {
                       const double x = middle(a)[axis], y = middle(b)[axis];
                       return x != y ? x < y : a < b;
                     });
  }

  /// As few levels of packets as hold the pieces of any leaf; every child is full but the last.
  void AddBelowLeaves() {
    std::vector<Range> here;
    std::size_t most = 0;
    for (std::size_t i = 0; i < order_.size();) {
      std::size_t end = i + 1;
      while (end < order_.size() && pieces_[order_[end]].leaf == pieces_[order_[i]].leaf) ++end;
      here.push_back(Range(order_).subspan(i, end - i));
      most = std::max(most, end - i);
      i = end;
    }
    leaf_ranges_ = here;
    const auto sphere_levels = static_cast<std::size_t>(spheres_.levels());
    std::size_t levels = 1, below_child = 1;
    for (; below_child * kTreeArity < most; below_child *= kTreeArity) ++levels;
    packets_.resize(sphere_levels + levels);
    for (std::size_t l = 0; l < levels; ++l, below_child /= kTreeArity) {
      std::vector<Range> next;
      for (const Range& range : here) {
        std::vector<Range> parts{range};
        for (int round = 0; round < 3; ++round) {
          std::vector<Range> halves;
          for (const Range& part : parts) {
            const std::size_t children = (part.size() + below_child - 1) / below_child;
            if (children <= 1) {
              halves.push_back(part);
              continue;
            }
            const std::size_t first = children / 2 * below_child;
            Divide(part, first);
            halves.push_back(part.first(first));
            halves.push_back(part.subspan(first));
          }
          parts = std::move(halves);
        }
        SpherePacket packet = EmptyPacket();
        for (std::size_t lane = 0; lane < parts.size(); ++lane) {
          SetLane(packet, lane, CentreOf(parts[lane]), parts[lane],
                  static_cast<std::int32_t>(next.size()));
          next.push_back(parts[lane]);
        }
        packets_[sphere_levels + l].push_back(packet);
      }
      here = std::move(next);
    }
    for (const std::uint32_t& i : order_) {
      const Vec3 centre = CentreOf(std::span(&i, 1));
      tree_.leaf_x.push_back(centre.x());
      tree_.leaf_y.push_back(centre.y());
      tree_.leaf_z.push_back(centre.z());
      tree_.leaf_radius.push_back(RadiusAbout(centre, std::span(&i, 1)));
    }
  }

  /// The sphere tree's own levels: same nodes, same centres, radii that hold the pieces below.
  void AddSphereLevels() {
    std::vector<std::int32_t> packet_of_leaf(spheres_.leaves(), -1);
    for (std::size_t i = 0; i < leaf_ranges_.size(); ++i) {
      packet_of_leaf[pieces_[leaf_ranges_[i].front()].leaf] = static_cast<std::int32_t>(i);
    }
    // Pieces below each node of the level below; leaves first.
    std::vector<std::vector<std::uint32_t>> below(spheres_.leaves());
    for (const Range& range : leaf_ranges_) {
      below[pieces_[range.front()].leaf].assign(range.begin(), range.end());
    }
    for (int l = spheres_.levels() - 1; l >= 0; --l) {
      const bool last = l + 1 == spheres_.levels();
      std::vector<std::vector<std::uint32_t>> here;
      for (const SpherePacket& in : spheres_.level(l)) {
        SpherePacket packet = EmptyPacket();
        std::vector<std::uint32_t> all;
        for (std::size_t lane = 0; lane < kTreeArity; ++lane) {
          if (in.child[lane] < 0) continue;
          const auto child = static_cast<std::size_t>(in.child[lane]);
          if (below[child].empty()) continue;
          const Vec3 centre = last ? LeafCentre(static_cast<std::uint32_t>(child))
                                   : X_FB_ * Vec3(in.x[lane], in.y[lane], in.z[lane]);
          SetLane(packet, lane, centre, below[child],
                  last ? packet_of_leaf[child] : in.child[lane]);
          all.insert(all.end(), below[child].begin(), below[child].end());
        }
        packets_[static_cast<std::size_t>(l)].push_back(packet);
        here.push_back(std::move(all));
      }
      below = std::move(here);
    }
  }

  const SphereTree& spheres_;
  const Pose& X_FB_;
  const std::vector<SurfacePiece>& pieces_;
  std::vector<std::uint32_t>& order_;
  std::vector<Range> leaf_ranges_;  ///< of order_, of each leaf that has pieces
  std::vector<std::vector<SpherePacket>> packets_;
  SphereTree tree_;
};

}  // namespace

SphereTree MakeSurfaceTree(const SphereTree& spheres, const Pose& X_FB,
                           const std::vector<SurfacePiece>& pieces,
                           std::vector<std::uint32_t>& order) {
  return SurfaceTreeBuilder(spheres, X_FB, pieces, order).Take();
}

}  // namespace palpate
