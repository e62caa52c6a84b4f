#include "server/physics/surface/hull_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <future>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include <Eigen/Eigenvalues>

namespace palpate {
namespace {

using Triangles = std::span<std::uint32_t>;

/// A patch with more eights of corners gets a box instead: scanning this many costs as much as two
/// scans of its halves.  Taken.
constexpr std::size_t kMostEights = 32;
/// From this many triangles on, half a patch is built in a thread of its own: a tenth
/// of a second. Taken.
constexpr std::size_t kOwnThread = 1 << 16;
/// Prefetch distance in triangles: in the larger patches of a scene, each lies
/// elsewhere in memory. Taken.
constexpr std::size_t kAhead = 8;

/// Calls `work` with the corners of each triangle of a patch.
template <class Work>
void ForEach(Triangles patch, const std::vector<Mat3>& corners, const Work& work) {
  for (std::size_t i = 0; i < patch.size(); ++i) {
    if (i + kAhead < patch.size()) {
      const Mat3& ahead = corners[patch[i + kAhead]];
      __builtin_prefetch(&ahead);
      __builtin_prefetch(ahead.data() + 8);
    }
    work(corners[patch[i]]);
  }
}

/// Returns the principal axes of a patch, by the second moments of its area or, if it has
/// none, of its corners.
Mat3 PrincipalAxes(const std::vector<Mat3>& corners, Triangles patch) {
  double moments[6] = {};  // xx, yx, zx, yy, zy, zz: the others are the same
  Vec3 sum = Vec3::Zero();
  double area = 0.0;
  const Vec3 origin = corners[patch[0]].col(0);
  ForEach(patch, corners, [&](const Mat3& x) {
    const Vec3 a = x.col(0) - origin, b = x.col(1) - origin, c = x.col(2) - origin;
    const double weight = (b - a).cross(c - a).norm() + 1e-300;
    const Vec3 all = a + b + c;
    // For a uniform triangle: (9 m m^T + a a^T + b b^T + c c^T) / 12, m its middle.
    const double third = weight / 3.0, share = 0.25 * third;
    for (int j = 0, entry = 0; j < 3; ++j) {
      for (int i = j; i < 3; ++i, ++entry) {
        moments[entry] += share * (all[i] * all[j] + a[i] * a[j] + b[i] * b[j] + c[i] * c[j]);
      }
    }
    sum += third * all;
    area += weight;
  });
  Mat3 second;
  second << moments[0], moments[1], moments[2],  //
      moments[1], moments[3], moments[4],        //
      moments[2], moments[4], moments[5];
  second = second / area - (sum / area) * (sum / area).transpose();
  const double scale = second.trace();
  if (!(scale > 0.0)) return Mat3::Identity();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(second / scale);
  return solver.info() == Eigen::Success ? Mat3(solver.eigenvectors()) : Mat3(Mat3::Identity());
}

/// A triangle, and the position of its centre along an axis.
using Place = std::pair<double, std::uint32_t>;

/// Buffers for sorting a patch, each as long as its number of triangles.
struct Room {
  std::span<Place> places, dealt;
  std::span<std::uint32_t> ends;
};

std::span<const Place> Sorted(std::span<Place> places) {
  std::ranges::sort(places);
  return places;
}

/// Returns the places sorted, ties by triangle.  Triangles lie about evenly along a patch, so they
/// are first distributed to as many intervals of it (bucket sort).
std::span<const Place> Sorted(const Room& room) {
  constexpr std::size_t kFew = 32;  // sorts these as fast without buckets; taken
  const std::span<Place> places = room.places;
  if (places.size() < kFew) return Sorted(places);
  const auto [least, most] = std::ranges::minmax(places, {}, &Place::first);
  const double low = least.first;
  const double scale = static_cast<double>(places.size() - 1) / (most.first - low);
  if (!(std::isfinite(scale) && scale > 0.0)) return Sorted(places);
  const auto stretch = [low, scale](const Place& place) {
    return static_cast<std::size_t>((place.first - low) * scale);
  };
  std::ranges::fill(room.ends, 0u);
  for (const Place& place : places) ++room.ends[stretch(place)];
  std::exclusive_scan(room.ends.begin(), room.ends.end(), room.ends.begin(), 0u);
  for (const Place& place : places) room.dealt[room.ends[stretch(place)]++] = place;
  std::uint32_t begin = 0;
  for (const std::uint32_t end : room.ends) {
    if (end - begin > 1) std::ranges::sort(room.dealt.subspan(begin, end - begin));
    begin = end;
  }
  return room.dealt;
}

/// Up to eight distinct corners, by the numbers of the mesh's vertices.
class FewCorners {
 public:
  bool empty() const { return count_ == 0; }
  /// From the count on, the last corner.
  std::uint32_t operator[](std::size_t i) const { return corners_[std::min(i, count_ - 1)]; }
  /// Returns a bit for each place that holds the vertex.
  std::uint32_t LanesOf(std::uint32_t vertex) const {
    std::uint32_t lanes = 0;
    for (unsigned k = 0; k < corners_.size(); ++k)
      lanes |= std::uint32_t{(*this)[k] == vertex} << k;
    return lanes;
  }
  /// Returns false if it would be the ninth.
  bool Add(std::uint32_t vertex) {
    const auto end = corners_.begin() + static_cast<std::ptrdiff_t>(count_);
    if (std::find(corners_.begin(), end, vertex) != end) return true;
    if (count_ == corners_.size()) return false;
    corners_[count_++] = vertex;
    return true;
  }
  bool Add(const FewCorners& others) {
    for (std::size_t i = 0; i < others.count_; ++i) {
      if (!Add(others.corners_[i])) return false;
    }
    return true;
  }

 private:
  std::array<std::uint32_t, 8> corners_;
  std::size_t count_ = 0;
};

}  // namespace

class HullTree::Builder {
 public:
  /// @param along_axes  whether all boxes lie along the frame's axes; if not, each has its own
  Builder(HullTree& tree, const ContactMesh& mesh, Scratch& scratch, bool along_axes = false)
      : tree_(tree), mesh_(mesh), scratch_(scratch), along_axes_(along_axes) {}

  void Build(std::size_t count, const std::vector<bool>& set = {}) {
    MakeLeaves(count);
    tree_.hulls_.eights.clear();
    tree_.hulls_.boxes.clear();
    tree_.inner_.resize(std::max(count, std::size_t{1}) - 1);
    tree_.corners_.resize(tree_.inner_.size());
    if (count < 2) return;
    scratch_.order.resize(count);
    std::iota(scratch_.order.begin(), scratch_.order.end(), 0u);
    if (!along_axes_) {
      scratch_.places.resize(count);
      scratch_.dealt.resize(count);
      scratch_.ends.resize(count);
    }
    if (!set.empty()) {
      const auto rest =
          std::stable_partition(scratch_.order.begin(), scratch_.order.end(),
                                [&](std::uint32_t triangle) { return set[triangle]; });
      first_half_ = static_cast<std::size_t>(rest - scratch_.order.begin()) % count;
    }
    const FewCorners all = BuildBelow({scratch_.order, 0}, tree_.hulls_);
    if (!all.empty()) AddEight(tree_.root(), all, tree_.hulls_);
  }

 private:
  /// A patch, and the inner node that it becomes if it has more than one triangle.
  struct Work {
    Triangles patch;
    Node inner;
    Node node() const { return patch.size() == 1 ? ~static_cast<Node>(patch[0]) : inner; }
  };

  void MakeLeaves(std::size_t count) {
    if (along_axes_) scratch_.bounds.resize(count);
    tree_.leaf_corners_.resize(count);
    tree_.leaf_centre_.resize(count);
    tree_.leaf_radius_.resize(count);
    for (std::size_t t = 0; t < count; ++t) {
      Mat3& corners = tree_.leaf_corners_[t];
      for (int c = 0; c < 3; ++c) corners.col(c) = mesh_.Corner(t, c);
      const Vec3 centre = (mesh_.Corner(t, 0) + mesh_.Corner(t, 1) + mesh_.Corner(t, 2)) / 3.0;
      double radius = 0.0;
      for (int c = 0; c < 3; ++c) radius = std::max(radius, (mesh_.Corner(t, c) - centre).norm());
      tree_.leaf_centre_[t] = centre;
      tree_.leaf_radius_[t] = radius;
      if (!along_axes_) continue;
      scratch_.bounds[t] = {corners.rowwise().minCoeff(), corners.rowwise().maxCoeff()};
    }
  }

  /// Makes the nodes of a patch, and adds their hulls.  Returns all corners if they are few and
  /// were not added.
  FewCorners BuildBelow(const Work& work, Hulls& hulls) {
    FewCorners one, other;
    if (work.patch.size() == 1) {
      for (const std::uint32_t v : mesh_.triangles()[work.patch[0]].vertex) one.Add(v);
      return one;
    }
    const std::size_t first = hulls.eights.size();
    OrientedBox box;
    const auto halves = Split(work, box);
    if (work.patch.size() < 2 * kOwnThread) {
      one = BuildBelow(halves[0], hulls);
      other = BuildBelow(halves[1], hulls);
    } else {
      Hulls others;
      // If there is no thread for it, it runs at get().
      std::future<FewCorners> making = std::async([&] { return BuildBelow(halves[1], others); });
      one = BuildBelow(halves[0], hulls);
      other = making.get();
      const auto eights = static_cast<std::uint32_t>(hulls.eights.size());
      const auto boxes = static_cast<std::uint32_t>(hulls.boxes.size());
      const auto corners =
          std::span(tree_.corners_)
              .subspan(static_cast<std::size_t>(halves[1].inner), halves[1].patch.size() - 1);
      for (Corners& of : corners) of.first += of.eights > 0 ? eights : boxes;
      hulls.eights.insert(hulls.eights.end(), others.eights.begin(), others.eights.end());
      hulls.boxes.insert(hulls.boxes.end(), others.boxes.begin(), others.boxes.end());
    }
    return Join(work.inner, first, one, other, box, hulls);
  }

  /// Makes the node, and splits its patch across its longest side.
  std::array<Work, 2> Split(const Work& work, OrientedBox& box) {
    Inner inner;
    const Mat3 axes =
        along_axes_ ? Mat3(Mat3::Identity()) : PrincipalAxes(tree_.leaf_corners_, work.patch);
    const Bounds bounds = BoundsOf(work.patch, axes);
    // A billionth of the size covers the rounding of the axes, which are orthogonal to 1e-15.
    const Vec3 size = bounds.high - bounds.low;
    const Vec3 half = (0.5 * size).array() + 1e-9 * size.maxCoeff();
    std::array<int, 3> order_of{0, 1, 2};
    std::sort(order_of.begin(), order_of.end(),
              [&](int a, int b) { return half[a] != half[b] ? half[a] < half[b] : a < b; });
    for (int c = 0; c < 3; ++c) {
      const int k = order_of[static_cast<std::size_t>(c)];
      box.sides.col(c) = half[k] * axes.col(k);
    }
    box.centre = axes * (0.5 * (bounds.low + bounds.high));
    inner.centre = box.centre;
    inner.radius = along_axes_ ? half.norm() : RadiusOf(work.patch, box.centre);
    std::size_t middle = work.patch.size() / 2;
    if (work.inner == 0 && first_half_ > 0) {
      middle = first_half_;
    } else if (along_axes_) {
      HalveAlong(order_of[2], work.patch);
    } else {
      SortAlong(axes.col(order_of[2]), work.patch);
    }
    // A patch of n triangles has n - 1 inner nodes, the first half's before the second's.
    const std::array halves{
        Work{work.patch.first(middle), work.inner + 1},
        Work{work.patch.subspan(middle), work.inner + static_cast<Node>(middle)}};
    for (std::size_t side = 0; side < 2; ++side) inner.child[side] = halves[side].node();
    tree_.inner_[static_cast<std::size_t>(work.inner)] = inner;
    return halves;
  }

  Bounds BoundsOf(Triangles patch, const Mat3& axes) const {
    const double far = std::numeric_limits<double>::infinity();
    Bounds all{Vec3::Constant(far), Vec3::Constant(-far)};
    if (along_axes_) {
      for (const std::uint32_t t : patch) {
        all.low = all.low.cwiseMin(scratch_.bounds[t].low);
        all.high = all.high.cwiseMax(scratch_.bounds[t].high);
      }
      return all;
    }
    ForEach(patch, tree_.leaf_corners_, [&](const Mat3& corners) {
      for (int c = 0; c < 3; ++c) {
        const Vec3 x = axes.transpose() * corners.col(c);
        all.low = all.low.cwiseMin(x);
        all.high = all.high.cwiseMax(x);
      }
    });
    return all;
  }

  double RadiusOf(Triangles patch, const Vec3& centre) const {
    double square = 0.0;
    ForEach(patch, tree_.leaf_corners_, [&](const Mat3& corners) {
      for (int c = 0; c < 3; ++c) {
        square = std::max(square, (corners.col(c) - centre).squaredNorm());
      }
    });
    return std::sqrt(square);
  }

  void SortAlong(const Vec3& axis, Triangles patch) {
    const Room room = RoomOf(patch);
    std::ranges::transform(patch, room.places.begin(), [&](std::uint32_t t) {
      return Place(axis.dot(tree_.leaf_centre_[t]), t);
    });
    std::ranges::transform(Sorted(room), patch.begin(), &Place::second);
  }

  /// Determines only which triangles belong to which half, which takes less than sorting them.
  void HalveAlong(int axis, Triangles patch) {
    const auto place = [&](std::uint32_t t) {
      return Place(scratch_.bounds[t].low[axis] + scratch_.bounds[t].high[axis], t);
    };
    std::ranges::nth_element(patch, patch.begin() + static_cast<std::ptrdiff_t>(patch.size() / 2),
                             {}, place);
  }

  /// @param first  of the points below the node
  FewCorners Join(Node node, std::size_t first, const FewCorners& one, const FewCorners& other,
                  const OrientedBox& box, Hulls& hulls) {
    if (!one.empty() && !other.empty()) {
      FewCorners both = one;
      if (both.Add(other)) return both;
    }
    const auto& child = tree_.inner(node).child;
    if (!one.empty()) AddEight(child[0], one, hulls);
    if (!other.empty()) AddEight(child[1], other, hulls);
    Corners& corners = tree_.corners_[static_cast<std::size_t>(node)];
    const auto eights = static_cast<std::uint32_t>(hulls.eights.size() - first);
    if (eights <= kMostEights) {
      corners = {static_cast<std::uint32_t>(first), eights, 0xff};
    } else {
      corners = {static_cast<std::uint32_t>(hulls.boxes.size()), 0, 0};
      hulls.boxes.push_back(box);
    }
    return {};
  }

  /// Repeats the last corner to make eight.
  void AddEight(Node node, const FewCorners& corners, Hulls& hulls) {
    EightPoints& eight = hulls.eights.emplace_back();
    for (std::size_t k = 0; k < 8; ++k) {
      for (int c = 0; c < 3; ++c) eight.x[c][k] = mesh_.vertices()[corners[k]][c];
    }
    Assign(node, corners, static_cast<std::uint32_t>(hulls.eights.size() - 1));
  }

  /// Gives a node and all nodes below it their lanes of an eight; returns the node's, one bit each.
  std::uint32_t Assign(Node node, const FewCorners& eight, std::uint32_t number) {
    std::uint32_t lanes = 0;
    if (!IsLeaf(node)) {
      for (const Node child : tree_.inner(node).child) lanes |= Assign(child, eight, number);
      tree_.corners_[static_cast<std::size_t>(node)] = {number, 1, lanes};
      return lanes;
    }
    for (const std::uint32_t v : mesh_.triangles()[TriangleOf(node)].vertex) {
      lanes |= eight.LanesOf(v);
    }
    return lanes;
  }

  Room RoomOf(Triangles patch) {
    const auto begin = static_cast<std::size_t>(patch.data() - scratch_.order.data());
    return {std::span(scratch_.places).subspan(begin, patch.size()),
            std::span(scratch_.dealt).subspan(begin, patch.size()),
            std::span(scratch_.ends).subspan(begin, patch.size())};
  }

  HullTree& tree_;
  const ContactMesh& mesh_;
  Scratch& scratch_;
  bool along_axes_;
  std::size_t first_half_ = 0;  ///< triangles of the root's first half; 0: not given
};

HullTree::HullTree(const ContactMesh& mesh, const std::vector<bool>& set) {
  Scratch scratch;
  Builder(*this, mesh, scratch).Build(mesh.triangles().size(), set);
}

void HullTree::Reserve(std::size_t triangles) {
  ReserveEach(triangles, inner_, corners_, hulls_.eights, leaf_corners_, leaf_centre_,
              leaf_radius_);
  // A patch with a box has more triangles than kMostEights, and halves differ by one.
  hulls_.boxes.reserve(4 * triangles / kMostEights);
}

void HullTree::Assign(const ContactMesh& mesh, std::size_t count, Scratch& scratch) {
  Builder(*this, mesh, scratch, true).Build(count);
}

HullTree::HullTree(std::span<Box> boxes) {
  if (!boxes.empty()) AddBoxes(boxes);
}

HullTree::Node HullTree::AddBoxes(std::span<Box> boxes) {
  Vec3 low = boxes[0].low, high = boxes[0].high;
  for (const Box& one : boxes) {
    low = low.cwiseMin(one.low);
    high = high.cwiseMax(one.high);
  }
  const Vec3 extent = 0.5 * (high - low);
  std::array<int, 3> by_length{0, 1, 2};
  std::ranges::stable_sort(by_length, {}, [&](int a) { return extent[a]; });
  const auto node = static_cast<std::size_t>(inner_.size());
  OrientedBox box{0.5 * (low + high), Mat3::Zero()};
  for (int c = 0; c < 3; ++c) {
    const int axis = by_length[static_cast<std::size_t>(c)];
    box.sides.col(c) = extent[axis] * Vec3::Unit(axis);
  }
  corners_.push_back({static_cast<std::uint32_t>(hulls_.boxes.size()), 0, 0});
  hulls_.boxes.push_back(box);
  inner_.push_back({box.centre, extent.norm(), {}});
  if (boxes.size() == 1) {
    inner_[node].child[0] = inner_[node].child[1] = ~static_cast<Node>(boxes[0].block);
    return static_cast<Node>(node);
  }
  const std::size_t middle = boxes.size() / 2;
  const int longest = by_length[2];
  std::ranges::stable_sort(boxes, {},
                           [&](const Box& one) { return one.low[longest] + one.high[longest]; });
  for (int side = 0; side < 2; ++side) {
    const Node child = AddBoxes(side == 0 ? boxes.first(middle) : boxes.subspan(middle));
    inner_[node].child[side] = child;
  }
  return static_cast<Node>(node);
}

}  // namespace palpate
