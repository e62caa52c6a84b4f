#include "server/physics/surface/surface_tree.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <span>

#include "common/math/float_rounding.h"

namespace palpate {
namespace {

using Pieces = std::span<const std::uint32_t>;

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
    for (const SurfacePiece& piece : pieces) {
      middle_.push_back((piece.corner[0] + piece.corner[1] + piece.corner[2]) / 3.0);
    }
    std::stable_sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
      return pieces[a].leaf < pieces[b].leaf;
    });
    AddLevels();
    AddLeaves();
  }

  SphereTree Take() { return std::move(tree_); }

 private:
  /// What a lane stands for: a packet of the level below, and the pieces below that.
  struct Node {
    std::vector<std::uint32_t> pieces;
    std::int32_t child;
    Vec3 centre;  ///< of the sphere that it has come from, or of the first of them
  };
  using Nodes = std::vector<Node>;

  Vec3 LeafCentre(std::uint32_t leaf) const {
    return X_FB_ * Vec3(spheres_.leaf_x[leaf], spheres_.leaf_y[leaf], spheres_.leaf_z[leaf]);
  }

  double RadiusAbout(const Vec3& centre, Pieces pieces) const {
    double radius = 0.0;
    for (std::uint32_t i : pieces) {
      for (const Vec3& corner : pieces_[i].corner) {
        radius = std::max(radius, (corner - centre).norm() + pieces_[i].slack);
      }
    }
    return radius;
  }

  Vec3 MiddleOf(Pieces pieces) const {
    Vec3 middle = Vec3::Zero();
    for (std::uint32_t i : pieces) middle += middle_[i];
    return middle / static_cast<double>(pieces.size());
  }

  /// Centre of the ball of some pieces.  A ball about a place far behind them stands out in front
  /// of them least, and the body's own spheres, which touch its surface from within, are as far
  /// behind as they can be without standing out elsewhere.
  Vec3 CentreOf(const Node& node) const {
    constexpr std::size_t kTried = 8, kMany = 512;
    Vec3 best = node.centre;
    double least = std::numeric_limits<double>::infinity();
    const auto consider = [&](const Vec3& centre) {
      const double radius = RadiusAbout(centre, node.pieces);
      double out = 0.0;
      for (std::uint32_t i : node.pieces) out += radius - (middle_[i] - centre).norm();
      if (out >= least) return;
      least = out;
      best = centre;
    };
    const Vec3 middle = MiddleOf(node.pieces);
    if (node.pieces.size() > kMany) {
      return RadiusAbout(middle, node.pieces) < RadiusAbout(best, node.pieces) ? middle : best;
    }
    consider(node.centre);
    consider(middle);
    const std::size_t stride = (node.pieces.size() + kTried - 1) / kTried;
    for (std::size_t i = 0; i < node.pieces.size(); i += stride) {
      consider(LeafCentre(pieces_[node.pieces[i]].leaf));
    }
    return best;
  }

  void SetLane(SpherePacket& packet, std::size_t lane, const Vec3& centre, Pieces pieces,
               std::int32_t child) const {
    packet.x[lane] = RoundToFloat(centre.x());
    packet.y[lane] = RoundToFloat(centre.y());
    packet.z[lane] = RoundToFloat(centre.z());
    const Vec3 rounded(packet.x[lane], packet.y[lane], packet.z[lane]);
    packet.radius[lane] = std::nextafter(RoundToFloat(RadiusAbout(rounded, pieces)),
                                         std::numeric_limits<float>::infinity());
    packet.child[lane] = child;
  }

  /// Sorts things into as few parts of at most eight as hold them, neighbours together, and calls
  /// each(part).  @param place  of a thing
  template <class T, class Place, class Each>
  void InEights(std::span<T> things, const Place& place, const Each& each) const {
    const std::size_t parts = (things.size() + kTreeArity - 1) / kTreeArity;
    if (parts <= 1) return each(things);
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const T& thing : things) {
      low = low.cwiseMin(place(thing));
      high = high.cwiseMax(place(thing));
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    std::stable_sort(things.begin(), things.end(),
                     [&](const T& a, const T& b) { return place(a)[axis] < place(b)[axis]; });
    const std::size_t first = things.size() * (parts / 2) / parts;
    InEights(things.first(first), place, each);
    InEights(things.subspan(first), place, each);
  }

  /// Packets for some nodes, added to a level; returns what stands for each in the level above.
  Nodes AddPackets(Nodes& nodes, const Vec3* centre, std::vector<SpherePacket>& level) const {
    Nodes made;
    const auto add = [&](std::span<Node> part) {
      SpherePacket packet = EmptyPacket();
      Node above{{}, static_cast<std::int32_t>(level.size()), Vec3::Zero()};
      for (std::size_t lane = 0; lane < part.size(); ++lane) {
        const Node& node = part[lane];
        SetLane(packet, lane, CentreOf(node), node.pieces, node.child);
        above.pieces.insert(above.pieces.end(), node.pieces.begin(), node.pieces.end());
      }
      above.centre = centre != nullptr ? *centre : MiddleOf(above.pieces);
      level.push_back(packet);
      made.push_back(std::move(above));
    };
    if (!nodes.empty())
      InEights(
          std::span(nodes), [&](const Node& n) { return MiddleOf(n.pieces); }, add);
    return made;
  }

  /// Packets of pieces, each of one leaf, or of two or three where that saves the leaf's own packet
  /// a ninth child.  Returns what each leaf has below it.
  std::vector<Nodes> AddPieces(std::vector<SpherePacket>& level) {
    std::vector<Nodes> of_leaf(spheres_.leaves());
    for (std::size_t i = 0; i < order_.size();) {
      std::size_t end = i + 1;
      const std::uint32_t leaf = pieces_[order_[i]].leaf;
      while (end < order_.size() && pieces_[order_[end]].leaf == leaf) ++end;
      InEights(
          std::span(order_).subspan(i, end - i), [&](std::uint32_t k) { return middle_[k]; },
          [&](Pieces part) {
            of_leaf[leaf].push_back({{part.begin(), part.end()}, 0, LeafCentre(leaf)});
          });
      i = end;
    }
    order_.clear();
    for (const SpherePacket& packet : spheres_.level(spheres_.levels() - 1)) {
      Join(packet, of_leaf);
      for (std::int32_t leaf : packet.child) {
        if (leaf < 0) continue;
        for (Node& node : of_leaf[static_cast<std::size_t>(leaf)]) {
          node.child = static_cast<std::int32_t>(level.size());
          SpherePacket& out = level.emplace_back(EmptyPacket());
          // The ball of one piece is that round its middle: its packet's has told how far in front
          // of the surface a place is, this one tells where along it.
          for (std::size_t lane = 0; lane < node.pieces.size(); ++lane) {
            SetLane(out, lane, middle_[node.pieces[lane]], Pieces(node.pieces).subspan(lane, 1),
                    static_cast<std::int32_t>(order_.size()));
            order_.push_back(node.pieces[lane]);
          }
        }
      }
    }
    return of_leaf;
  }

  /// Joins nodes of neighbouring leaves until a packet has room for them all, where it can.
  void Join(const SpherePacket& packet, std::vector<Nodes>& of_leaf) const {
    for (;;) {
      std::vector<std::pair<Nodes*, std::size_t>> nodes;
      std::size_t pieces = 0;
      for (std::int32_t leaf : packet.child) {
        if (leaf < 0) continue;
        Nodes& own = of_leaf[static_cast<std::size_t>(leaf)];
        for (std::size_t k = 0; k < own.size(); ++k) {
          nodes.emplace_back(&own, k);
          pieces += own[k].pieces.size();
        }
      }
      constexpr std::size_t kFull = kTreeArity * kTreeArity;
      if (nodes.size() <= kTreeArity * ((pieces + kFull - 1) / kFull)) return;
      double least = std::numeric_limits<double>::infinity();
      std::size_t first = 0, second = 0;
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        for (std::size_t j = i + 1; j < nodes.size(); ++j) {
          const Node &a = (*nodes[i].first)[nodes[i].second],
                     &b = (*nodes[j].first)[nodes[j].second];
          if (a.pieces.size() + b.pieces.size() > kTreeArity) continue;
          const double apart = (MiddleOf(a.pieces) - MiddleOf(b.pieces)).norm();
          if (apart >= least) continue;
          least = apart;
          first = i;
          second = j;
        }
      }
      if (second == 0) return;
      Node& a = (*nodes[first].first)[nodes[first].second];
      Nodes& from = *nodes[second].first;
      const auto b = from.begin() + static_cast<std::ptrdiff_t>(nodes[second].second);
      a.pieces.insert(a.pieces.end(), b->pieces.begin(), b->pieces.end());
      from.erase(b);
    }
  }

  /// From the bottom up, as a B-tree grows: below each leaf of the sphere tree its pieces in
  /// packets, then the sphere tree's own levels, where a node with more than eight children becomes
  /// several, and as many levels on top as that takes.
  void AddLevels() {
    std::vector<std::vector<SpherePacket>> levels(1);
    std::vector<Nodes> here = AddPieces(levels[0]);  // of each node of the level above
    for (int l = spheres_.levels() - 1; l >= 0; --l) {
      levels.emplace_back();
      std::vector<Vec3> centre_of(spheres_.level(l).size(), Vec3::Zero());
      if (l > 0) {
        for (const SpherePacket& above : spheres_.level(l - 1)) {
          for (int lane = 0; lane < kTreeArity; ++lane) {
            if (above.child[lane] < 0) continue;
            centre_of[static_cast<std::size_t>(above.child[lane])] =
                X_FB_ * Vec3(above.x[lane], above.y[lane], above.z[lane]);
          }
        }
      }
      std::vector<Nodes> next;
      for (const SpherePacket& packet : spheres_.level(l)) {
        Nodes children;
        for (std::int32_t child : packet.child) {
          if (child < 0) continue;
          Nodes& below = here[static_cast<std::size_t>(child)];
          std::move(below.begin(), below.end(), std::back_inserter(children));
        }
        next.push_back(
            AddPackets(children, l > 0 ? &centre_of[next.size()] : nullptr, levels.back()));
      }
      here = std::move(next);
    }
    while (here[0].size() > 1) {
      levels.emplace_back();
      Nodes top = AddPackets(here[0], nullptr, levels.back());
      here[0] = std::move(top);
    }
    tree_.level_begin.push_back(0);
    for (auto level = levels.rbegin(); level != levels.rend(); ++level) {
      tree_.packets.insert(tree_.packets.end(), level->begin(), level->end());
      tree_.level_begin.push_back(static_cast<std::int32_t>(tree_.packets.size()));
    }
  }

  void AddLeaves() {
    for (const std::uint32_t& i : order_) {
      const Vec3& centre = middle_[i];
      tree_.leaf_x.push_back(centre.x());
      tree_.leaf_y.push_back(centre.y());
      tree_.leaf_z.push_back(centre.z());
      tree_.leaf_radius.push_back(RadiusAbout(centre, Pieces(&i, 1)));
    }
  }

  const SphereTree& spheres_;
  const Pose& X_FB_;
  const std::vector<SurfacePiece>& pieces_;
  std::vector<std::uint32_t>& order_;
  std::vector<Vec3> middle_;
  SphereTree tree_;
};

}  // namespace

SphereTree MakeSurfaceTree(const SphereTree& spheres, const Pose& X_FB,
                           const std::vector<SurfacePiece>& pieces,
                           std::vector<std::uint32_t>& order) {
  return SurfaceTreeBuilder(spheres, X_FB, pieces, order).Take();
}

}  // namespace palpate
