#include "tests/support/mesh_oracle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "tests/support/triangle_tree.h"

namespace palpate::test {
namespace {

using Box = TriangleTree::Box;
using Node = TriangleTree::Node;

/// X_BT as a matrix, from poses whose quaternions may deviate from unit length by rounding.
class Motion {
 public:
  Motion(const Pose& X_WB, const Pose& X_WT) {
    const Mat3 R_BW = X_WB.q.normalized().toRotationMatrix().transpose();
    R_ = R_BW * X_WT.q.normalized().toRotationMatrix();
    p_ = R_BW * (X_WT.p - X_WB.p);
    absolute_ = R_.cwiseAbs();
  }
  Vec3 operator*(const Vec3& p) const { return R_ * p + p_; }
  Triangle operator*(const Triangle& t) const { return {*this * t[0], *this * t[1], *this * t[2]}; }
  /// Returns a bounding box of the moved box.
  Box operator*(const Box& box) const {
    const Vec3 center = *this * box.center;
    // Adds some ulps, so that rounding does not put inner corners outside.
    const double slack =
        1e-14 * (p_.cwiseAbs().sum() + box.center.cwiseAbs().sum() + box.half.sum());
    return {center, absolute_ * box.half + Vec3::Constant(slack)};
  }

 private:
  Mat3 R_, absolute_;
  Vec3 p_;
};

bool Apart(const Triangle& a, const Triangle& b) {
  for (int i = 0; i < 3; ++i) {
    if (std::max({a[0][i], a[1][i], a[2][i]}) < std::min({b[0][i], b[1][i], b[2][i]})) return true;
    if (std::max({b[0][i], b[1][i], b[2][i]}) < std::min({a[0][i], a[1][i], a[2][i]})) return true;
  }
  return false;
}

/// Visits pairs of leaves of `a`, moved, and `b` whose boxes overlap, until `visit` returns true.
template <class Visit>
bool VisitLeafPairs(const TriangleTree& a, const Motion& X_BA, const TriangleTree& b,
                    const Motion& X_AB, const Visit& visit) {
  if (a.empty() || b.empty()) return false;
  const auto step = [&](const auto& self, const Node& na, const Box& moved_a,
                        const Node& nb) -> bool {
    // Tests the axes of both boxes: a rotated box's bounding box is too large at its corners.
    if (!moved_a.Overlaps(nb.box) || !(X_AB * nb.box).Overlaps(na.box)) return false;
    if (na.leaf() && nb.leaf()) return visit(na, nb);
    if (nb.leaf() || (!na.leaf() && na.box.half.sum() > nb.box.half.sum())) {
      const Node &first = a.first(na), &second = a.second(na);
      return self(self, first, X_BA * first.box, nb) || self(self, second, X_BA * second.box, nb);
    }
    return self(self, na, moved_a, b.first(nb)) || self(self, na, moved_a, b.second(nb));
  };
  return step(step, a.root(), X_BA * a.root().box, b.root());
}

/// Vertices of a mesh, with the triangles at each.
class VertexFans {
 public:
  explicit VertexFans(const TriangleTree& mesh) : begin_(mesh.vertices().size() + 1) {
    for (std::uint32_t t = 0; t < mesh.triangles(); ++t) {
      for (const std::uint32_t v : mesh.corners(t)) ++begin_[v + 1];
    }
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    triangle_.resize(begin_.back());
    std::vector<std::uint32_t> at(begin_.begin(), begin_.end() - 1);
    for (std::uint32_t t = 0; t < mesh.triangles(); ++t) {
      for (const std::uint32_t v : mesh.corners(t)) triangle_[at[v]++] = t;
    }
    // One vertex of each connected part.
    std::vector<bool> seen(begin_.size() - 1);
    std::vector<std::uint32_t> stack;
    for (std::uint32_t v = 0; v + 1 < begin_.size(); ++v) {
      if (seen[v] || begin_[v] == begin_[v + 1]) continue;
      parts_.push_back(v);
      seen[v] = true;
      stack.push_back(v);
      while (!stack.empty()) {
        const std::uint32_t at_v = stack.back();
        stack.pop_back();
        for (const std::uint32_t t : Of(at_v)) {
          for (const std::uint32_t u : mesh.corners(t)) {
            if (seen[u]) continue;
            seen[u] = true;
            stack.push_back(u);
          }
        }
      }
    }
  }
  std::span<const std::uint32_t> Of(std::uint32_t vertex) const {
    return std::span(triangle_).subspan(begin_[vertex], begin_[vertex + 1] - begin_[vertex]);
  }
  const std::vector<std::uint32_t>& parts() const { return parts_; }

 private:
  std::vector<std::uint32_t> begin_, triangle_, parts_;
};

/// Returns the depth of the deepest vertex of `mesh` inside a closed mesh.  Triangles that do not
/// meet the other surface lie wholly on one side of it, so one vertex decides for all that are
/// connected by such triangles.  The search starts at the vertices of triangles that meet the
/// surface, and at one vertex of each connected part.
/// @param crossing  triangles of `mesh` that meet the other's surface; sorted.
/// @returns negative if none is inside.
double DeepestVertex(const TriangleTree& mesh, const VertexFans& fans, const Motion& X,
                     const TriangleTree& in, const std::vector<std::uint32_t>& crossing,
                     bool first_only) {
  double deepest = -1.0;
  if (!in.closed()) return deepest;
  std::vector<bool> known(mesh.vertices().size());
  std::vector<std::uint32_t> stack;
  const auto spread = [&](std::uint32_t from) {
    if (known[from]) return;
    // Does not continue from a vertex outside; its neighbours are tested themselves.
    known[from] = true;
    const Vec3 place = X * mesh.vertices()[from];
    if (!in.Contains(place)) return;
    stack.push_back(from);
    while (!stack.empty()) {
      const std::uint32_t v = stack.back();
      stack.pop_back();
      const double distance =
          in.Distance(X * mesh.vertices()[v], std::numeric_limits<double>::infinity());
      deepest = std::max(deepest, distance);
      if (first_only) {
        stack.clear();
        return;
      }
      for (const std::uint32_t t : fans.Of(v)) {
        if (std::binary_search(crossing.begin(), crossing.end(), t)) continue;
        for (const std::uint32_t u : mesh.corners(t)) {
          if (known[u]) continue;
          known[u] = true;
          stack.push_back(u);
        }
      }
    }
  };
  for (const std::uint32_t t : crossing) {
    for (const std::uint32_t v : mesh.corners(t)) spread(v);
  }
  for (const std::uint32_t v : fans.parts()) spread(v);
  return deepest;
}

}  // namespace

struct MeshOracle::Mesh {
  explicit Mesh(const TriangleMesh& mesh) : tree(mesh), fans(tree) {}
  TriangleTree tree;
  VertexFans fans;
};

struct MeshOracle::Object {
  explicit Object(const PlacedMesh& placed)
      : mesh(*placed.mesh), X_WB(placed.X_WB), placed(placed.X_WB), moved(placed.moved) {}
  Mesh mesh;
  Pose X_WB, placed;
  std::uint32_t moved;
};

MeshOracle::MeshOracle(const TriangleMesh& tool, std::span<const PlacedMesh> objects)
    : tool_(std::make_unique<const Mesh>(tool)), objects_(objects.begin(), objects.end()) {}

MeshOracle::MeshOracle(const ToolBall& tool, std::span<const PlacedMesh> objects)
    : ball_(tool), objects_(objects.begin(), objects.end()) {}

MeshOracle::MeshOracle(const Scene& scene) {
  const Body& tool = scene.tools.front();
  if (tool.tree.leaves() == 1) {
    ball_ = {{tool.tree.leaf_x[0], tool.tree.leaf_y[0], tool.tree.leaf_z[0]},
             tool.tree.leaf_radius[0]};
  } else {
    tool_ = std::make_unique<const Mesh>(tool.mesh);
  }
  for (const Body& body : scene.objects)
    objects_.emplace_back(PlacedMesh{&body.mesh, body.X_WB, body.moved});
}

void MeshOracle::Move(std::span<const Pose> groups) {
  for (Object& object : objects_) {
    if (object.moved > 0) object.X_WB = groups[object.moved - 1] * object.placed;
  }
}

MeshOracle::~MeshOracle() = default;
MeshOracle::MeshOracle(MeshOracle&&) noexcept = default;

MeshOracle::Overlap MeshOracle::At(const Pose& X_WT) const {
  return Find(X_WT, false);
}

bool MeshOracle::Meet(const Pose& X_WT) const {
  return Find(X_WT, true).meet;
}

MeshOracle::Overlap MeshOracle::Find(const Pose& X_WT, bool first_only) const {
  Overlap overlap;
  for (const Object& object : objects_) {
    if (tool_ != nullptr) {
      FindMesh(object, X_WT, first_only, overlap);
    } else {
      FindBall(object, X_WT, first_only, overlap);
    }
    if (first_only && overlap.meet) break;
  }
  return overlap;
}

void MeshOracle::FindMesh(const Object& object, const Pose& X_WT, bool first_only,
                          Overlap& overlap) const {
  const TriangleTree &tool = tool_->tree, &other = object.mesh.tree;
  const Motion X_BT(object.X_WB, X_WT), X_TB(X_WT, object.X_WB);
  std::vector<std::uint32_t> of_tool, of_object;
  const bool stopped =
      VisitLeafPairs(tool, X_BT, other, X_TB, [&](const Node& tool_leaf, const Node& leaf) {
        for (const std::uint32_t i : tool.TrianglesOf(tool_leaf)) {
          const Triangle a = X_BT * tool.At(i);
          for (const std::uint32_t k : other.TrianglesOf(leaf)) {
            const Triangle b = other.At(k);
            if (Apart(a, b) || !test::Meet(a, b)) continue;
            overlap.meet = true;
            if (first_only) return true;
            ++overlap.pairs;
            overlap.depth = std::max(overlap.depth, ShortestSeparation(a, b).depth);
            of_tool.push_back(i);
            of_object.push_back(k);
          }
        }
        return false;
      });
  if (stopped) return;
  const auto deepen = [&](double depth) {
    if (depth < 0.0) return;
    overlap.meet = true;
    overlap.depth = std::max(overlap.depth, depth);
  };
  for (std::vector<std::uint32_t>* crossing : {&of_tool, &of_object}) {
    std::sort(crossing->begin(), crossing->end());
    crossing->erase(std::unique(crossing->begin(), crossing->end()), crossing->end());
  }
  deepen(DeepestVertex(tool, tool_->fans, X_BT, other, of_tool, first_only));
  deepen(DeepestVertex(other, object.mesh.fans, X_TB, tool, of_object, first_only));
}

void MeshOracle::FindBall(const Object& object, const Pose& X_WT, bool first_only,
                          Overlap& overlap) const {
  const TriangleTree& other = object.mesh.tree;
  const Vec3 center = Motion(object.X_WB, X_WT) * ball_.center;
  const bool inside = other.closed() && other.Contains(center);
  const double distance = other.Distance(center, inside ? std::numeric_limits<double>::infinity()
                                                        : std::nextafter(ball_.radius, INFINITY));
  if (!std::isfinite(distance)) return;
  overlap.meet = true;
  if (first_only) return;
  ++overlap.pairs;
  overlap.depth =
      std::max(overlap.depth, inside ? ball_.radius + distance : ball_.radius - distance);
}

MeshOracle::Gap MeshOracle::Distance(const Pose& X_WT) const {
  if (Meet(X_WT)) return {0.0, X_WT.p, X_WT.p};
  Gap gap{std::numeric_limits<double>::infinity(), X_WT.p, X_WT.p};
  for (const Object& object : objects_) {
    const TriangleTree& other = object.mesh.tree;
    const Motion X_BT(object.X_WB, X_WT), X_TB(X_WT, object.X_WB);
    if (tool_ == nullptr) {
      const Vec3 center = X_BT * ball_.center;
      Vec3 nearest;
      const double distance = other.Distance(center, gap.distance + ball_.radius, &nearest);
      if (!std::isfinite(distance)) continue;
      const Vec3 on_tool = center + (ball_.radius / distance) * (nearest - center);
      gap = {distance - ball_.radius, object.X_WB * on_tool, object.X_WB * nearest};
      continue;
    }
    const TriangleTree& tool = tool_->tree;
    if (tool.empty() || other.empty()) continue;
    const auto bound = [&](const Node& a, const Node& b) {
      return std::max((X_BT * a.box).Distance(b.box), a.box.Distance(X_TB * b.box));
    };
    const auto visit = [&](const auto& self, const Node& a, const Node& b) -> void {
      if (a.leaf() && b.leaf()) {
        for (const std::uint32_t i : tool.TrianglesOf(a)) {
          const Triangle moved = X_BT * tool.At(i);
          for (const std::uint32_t k : other.TrianglesOf(b)) {
            const Triangle still = other.At(k);
            if (TriangleTree::BoxOf(moved).Distance(TriangleTree::BoxOf(still)) >= gap.distance) {
              continue;
            }
            const Nearest nearest = NearestPoints(moved, still);
            if (nearest.distance < gap.distance) {
              gap = {nearest.distance, object.X_WB * nearest.on_a, object.X_WB * nearest.on_b};
            }
          }
        }
        return;
      }
      const bool split_a = b.leaf() || (!a.leaf() && a.box.half.sum() > b.box.half.sum());
      const Node *first_a = &a, *first_b = &b, *second_a = &a, *second_b = &b;
      if (split_a) {
        first_a = &tool.first(a);
        second_a = &tool.second(a);
      } else {
        first_b = &other.first(b);
        second_b = &other.second(b);
      }
      double near = bound(*first_a, *first_b), far = bound(*second_a, *second_b);
      if (far < near) {
        std::swap(near, far);
        std::swap(first_a, second_a);
        std::swap(first_b, second_b);
      }
      if (near < gap.distance) self(self, *first_a, *first_b);
      if (far < gap.distance) self(self, *second_a, *second_b);
    };
    visit(visit, tool.root(), other.root());
  }
  return gap;
}

}  // namespace palpate::test
