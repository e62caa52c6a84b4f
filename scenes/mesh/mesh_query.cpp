#include "scenes/mesh/mesh_query.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/math/solid_angle.h"

namespace palpate {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;

double SquaredDistanceToBox(const Vec3& p, const Vec3& min, const Vec3& max) {
  return (min - p).cwiseMax(p - max).cwiseMax(0.0).squaredNorm();
}

/// Returns the nearest point of segment ab; a if its length is 0.
Vec3 NearestOnSegment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double length2 = d.squaredNorm();
  return length2 > 0.0 ? Vec3(a + std::clamp((p - a).dot(d) / length2, 0.0, 1.0) * d) : a;
}

}  // namespace

Vec3 NearestOnTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ap = p - a;
  const double d1 = ab.dot(ap);
  const double d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp);
  const double d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp);
  const double d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return NearestOnSegment(p, a, b);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return NearestOnSegment(p, a, c);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) return NearestOnSegment(p, b, c);
  const double sum = va + vb + vc;
  if (sum > 0.0) return a + (vb / sum) * ab + (vc / sum) * ac;
  // Degenerate: take the nearest point of the three edges.
  Vec3 best = NearestOnSegment(p, a, b);
  for (const Vec3& q : {NearestOnSegment(p, b, c), NearestOnSegment(p, c, a)}) {
    if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
  }
  return best;
}

/// The contribution of a triangle to the nodes above it.
struct MeshQuery::Facet {
  Vec3 centroid;
  Vec3 area;      ///< area times unit normal [m^2]
  double size;    ///< |area|
  Vec3 weighted;  ///< size * centroid
};

MeshQuery::MeshQuery(const TriangleMesh& mesh) : mesh_(mesh) {
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  order_.resize(count);
  std::iota(order_.begin(), order_.end(), 0u);
  std::vector<Facet> facets(count);
  vertex_normals_.assign(mesh.vertices.size(), Vec3::Zero());
  for (std::uint32_t t = 0; t < count; ++t) {
    const Triangle triangle = TriangleOf(mesh, t);
    const Vec3 area = triangle.Across();
    for (const std::uint32_t v : mesh.triangles[t]) vertex_normals_[v] += area;
    Facet& facet = facets[t];
    facet.centroid = triangle.Middle();
    facet.area = 0.5 * area;
    facet.size = facet.area.norm();
    facet.weighted = facet.size * facet.centroid;
  }
  nodes_.reserve(2 * (count / 2 + 1));
  nodes_.emplace_back();
  nodes_[0].end = count;
  std::vector<Along> along(count);
  Build(0, facets, along);
  corners_.reserve(count);
  for (std::uint32_t t : order_) corners_.push_back(TriangleOf(mesh, t));
}

void MeshQuery::Build(std::int32_t index, const std::vector<Facet>& facets,
                      std::vector<Along>& along) {
  Node node = nodes_[index];
  node.min = Vec3::Constant(std::numeric_limits<double>::infinity());
  node.max = -node.min;
  node.dipole = node.centre = Vec3::Zero();
  Vec3 low = node.min;
  Vec3 high = node.max;
  double total = 0.0;
  for (std::uint32_t i = node.begin; i < node.end; ++i) {
    const Facet& facet = facets[order_[i]];
    low = low.cwiseMin(facet.centroid);
    high = high.cwiseMax(facet.centroid);
    node.dipole += facet.area;
    node.centre += facet.weighted;
    total += facet.size;
  }
  if (node.end - node.begin > kLeafTriangles) {
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::uint32_t middle = node.begin + (node.end - node.begin) / 2;
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
      along[i] = {facets[order_[i]].centroid[axis], order_[i]};
    }
    std::nth_element(along.begin() + node.begin, along.begin() + middle, along.begin() + node.end);
    for (std::uint32_t i = node.begin; i < node.end; ++i) order_[i] = along[i].second;
    node.child = static_cast<std::int32_t>(nodes_.size());
    nodes_.resize(nodes_.size() + 2);
    nodes_[node.child].begin = node.begin;
    nodes_[node.child].end = nodes_[node.child + 1].begin = middle;
    nodes_[node.child + 1].end = node.end;
    for (const std::int32_t child : {node.child, node.child + 1}) {
      Build(child, facets, along);
      node.min = node.min.cwiseMin(nodes_[child].min);
      node.max = node.max.cwiseMax(nodes_[child].max);
    }
  } else {
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
      for (const std::uint32_t v : mesh_.triangles[order_[i]]) {
        node.min = node.min.cwiseMin(mesh_.vertices[v]);
        node.max = node.max.cwiseMax(mesh_.vertices[v]);
      }
    }
  }
  node.centre = total > 0.0 ? Vec3(node.centre / total) : Vec3(0.5 * (node.min + node.max));
  node.reach = (node.max - node.centre).cwiseMax(node.centre - node.min).norm();
  nodes_[index] = node;
}

MeshQuery::Hit MeshQuery::Nearest(const Vec3& p, double within) const {
  Hit hit;
  double best = within * within;
  struct Entry {
    double distance2;
    std::int32_t node;
  };
  Entry stack[64];  // the tree halves its triangles, so 2^32 of them are 32 deep
  int top = 0;
  stack[top++] = {SquaredDistanceToBox(p, nodes_[0].min, nodes_[0].max), 0};
  while (top > 0) {
    const Entry entry = stack[--top];
    if (!(entry.distance2 < best)) continue;
    const Node& node = nodes_[entry.node];
    if (node.child < 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        const Triangle& t = corners_[i];
        const Vec3 q = NearestOnTriangle(p, t.a, t.b, t.c);
        const double distance2 = (q - p).squaredNorm();
        if (distance2 < best) {
          best = distance2;
          hit.point = q;
          hit.triangle = order_[i];
        }
      }
      continue;
    }
    Entry near{0.0, node.child};
    Entry far{0.0, node.child + 1};
    near.distance2 = SquaredDistanceToBox(p, nodes_[near.node].min, nodes_[near.node].max);
    far.distance2 = SquaredDistanceToBox(p, nodes_[far.node].min, nodes_[far.node].max);
    if (far.distance2 < near.distance2) std::swap(near, far);
    if (far.distance2 < best) stack[top++] = far;
    if (near.distance2 < best) stack[top++] = near;
  }
  if (hit.triangle != kNone) hit.distance = std::sqrt(best);
  return hit;
}

double MeshQuery::WindingNumber(const Vec3& p) const {
  constexpr double kFar = 2.0;  // in reaches, as Barill et al.
  constexpr double kPi = 3.14159265358979323846;
  double angle = 0.0;
  std::int32_t stack[64];
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    const Vec3 to_centre = node.centre - p;
    const double distance2 = to_centre.squaredNorm();
    if (distance2 > kFar * kFar * node.reach * node.reach) {
      angle += node.dipole.dot(to_centre) / (distance2 * std::sqrt(distance2));
    } else if (node.child < 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        const Triangle& t = corners_[i];
        angle += SolidAngle(t.a - p, t.b - p, t.c - p);
      }
    } else {
      stack[top++] = node.child;
      stack[top++] = node.child + 1;
    }
  }
  return angle / (4.0 * kPi);
}

Vec3 MeshQuery::FaceNormal(std::uint32_t triangle) const {
  const Vec3 n = TriangleOf(mesh_, triangle).Across();
  const double length = n.norm();
  return length > 0.0 ? Vec3(n / length) : Vec3(Vec3::Zero());
}

Vec3 MeshQuery::SmoothNormal(std::uint32_t triangle, const Vec3& point) const {
  const auto& [i, j, k] = mesh_.triangles[triangle];
  const Vec3& a = mesh_.vertices[i];
  const Vec3 ab = mesh_.vertices[j] - a;
  const Vec3 ac = mesh_.vertices[k] - a;
  const Vec3 n = ab.cross(ac);
  const double n2 = n.squaredNorm();
  if (!(n2 > 0.0)) return Vec3::Zero();
  const double v = (point - a).cross(ac).dot(n) / n2;
  const double w = ab.cross(point - a).dot(n) / n2;
  const Vec3 sum = (1.0 - v - w) * vertex_normals_[i].normalized() +
                   v * vertex_normals_[j].normalized() + w * vertex_normals_[k].normalized();
  const double length = sum.norm();
  return length > 1e-6 ? Vec3(sum / length) : FaceNormal(triangle);
}

}  // namespace palpate
