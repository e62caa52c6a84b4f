#include "server/physics/surface/contact_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "server/physics/surface/surface_mesh.h"
#include "server/physics/surface/surface_tree.h"

namespace palpate {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A normal that leaves its face's by less than this is the face's.
constexpr double kFlat = 1e-5;
/// SurfacePatch::outside of a patch with and without a crease.
constexpr double kAtCrease = 1e-9, kAcrossEdges = 0.02;
/// Least cosine between the normals of two smooth places that touch, one of them turned over.
constexpr double kOpposed = 0.3;
/// Reach of points on creases, which no side can leave to the other.
constexpr double kOnCrease = -1.0;
/// How far [rad] what touches a crease may leave the normals that meet there.
constexpr double kCreaseSlack = 0.1;
/// Least depth that a patch has below it [m]: linearising leaves some micrometres.
constexpr double kLeastDepth = 5e-6;

void Put(double* to, const Vec3& v) {
  for (int i = 0; i < 3; ++i) to[i] = v[i];
}

/// How the surface is to be cut: about as finely as the leaves sample it.
double LongestEdge(const TriangleMesh& mesh, std::size_t leaves) {
  double area = 0.0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3& a = mesh.vertices[i];
    area += 0.5 * (mesh.vertices[j] - a).cross(mesh.vertices[k] - a).norm();
  }
  return 1.5 * std::sqrt(area / static_cast<double>(leaves));
}

/// Leaves that list each triangle of the source mesh.
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
    double least = kInfinity;
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

/// Builds the parts of one surface, in frame B, then turns them into frame F and sorts them as
/// their trees' leaves lie.
class SurfaceBuilder {
 public:
  SurfaceBuilder(const TriangleMesh& mesh, const SphereTree& leaves, ContactSurface& out)
      : longest_edge_(LongestEdge(mesh, leaves.leaves())),
        surface_(MakeSurfaceMesh(mesh, longest_edge_)),
        leaves_(leaves),
        leaves_of_(leaves, mesh.triangles.size()),
        out_(out) {
    ClassifyVertices();
    AddVertices();
    AddPatches();
    AddCreases();
  }

  std::vector<SurfacePiece> point_pieces, patch_pieces, crease_pieces;

 private:
  using Triangle = SurfaceMesh::Triangle;

  const Vec3& Vertex(const Triangle& t, std::size_t corner) const {
    return surface_.vertices[t.vertex[corner]];
  }

  struct VertexKind {
    bool sharp = false;                 ///< on a crease
    bool convex = false;                ///< on a convex one
    bool concave = false, end = false;  ///< on a concave one; where the surface ends
    std::vector<Vec3> normals;          ///< on a crease: of its triangles and their corners there
    bool flat = true;                   ///< inside a plane
    Vec3 normal = Vec3::Zero();
    std::uint32_t triangle = 0;  ///< one of its
    double longest = 0.0;        ///< of its edges
    double reach = 0.0;          ///< of its point, where it has a smooth one
  };

  void ClassifyVertices() {
    kinds_.resize(surface_.vertices.size());
    creased_.resize(surface_.triangles.size());
    thickness_.resize(surface_.triangles.size(), kInfinity);
    for (const SurfaceMesh::SharpEdge& edge : surface_.sharp_edges) {
      for (std::uint32_t t : edge.triangle) creased_[t] = true;
      Thin(edge.triangle[0], edge.triangle[1], edge.convex);
      for (std::uint32_t v : edge.vertex) {
        kinds_[v].sharp = true;
        kinds_[v].convex = kinds_[v].convex || edge.convex;
        kinds_[v].concave = kinds_[v].concave || !edge.convex;
        kinds_[v].end = kinds_[v].end || edge.triangle[0] == edge.triangle[1];
      }
    }
    for (std::uint32_t i = 0; i < surface_.triangles.size(); ++i) {
      const Triangle& t = surface_.triangles[i];
      const Vec3 face = surface_.FaceNormal(i);
      for (std::size_t c = 0; c < 3; ++c) {
        VertexKind& kind = kinds_[t.vertex[c]];
        kind.triangle = i;
        if (kind.sharp) AppendNormals(i, std::span(&t.vertex[c], 1), kind.normals);
        kind.normal += t.normal[c];
        kind.flat = kind.flat && (t.normal[c] - face).norm() < kFlat;
        const double a = (Vertex(t, (c + 1) % 3) - Vertex(t, c)).norm();
        const double b = (Vertex(t, (c + 2) % 3) - Vertex(t, c)).norm();
        kind.longest = std::max({kind.longest, a, b});
      }
    }
    for (VertexKind& kind : kinds_) kind.normal.normalize();
  }

  /// The normals of a triangle, and of those of its corners that are among the vertices.
  void AppendNormals(std::uint32_t triangle, std::span<const std::uint32_t> vertices,
                     std::vector<Vec3>& normals) const {
    const Triangle& t = surface_.triangles[triangle];
    normals.push_back(surface_.FaceNormal(triangle));
    for (std::size_t c = 0; c < 3; ++c) {
      if (std::find(vertices.begin(), vertices.end(), t.vertex[c]) != vertices.end()) {
        normals.push_back(t.normal[c]);
      }
    }
  }

  /// Two triangles that meet at an edge by less than 60 degrees have less of the body between
  /// them than this; scans have triangles that lie back to back, with nothing between them.
  void Thin(std::uint32_t a, std::uint32_t b, bool convex) {
    constexpr double kSharp = -0.5,
                     kFolded = -0.9998;  // whether a fold is convex is then for rounding to say
    const Vec3 n_a = surface_.FaceNormal(a), n_b = surface_.FaceNormal(b);
    if (a == b || n_a.dot(n_b) >= (convex ? kSharp : kFolded)) return;
    const auto most = [&](std::uint32_t of, const Vec3& p, const Vec3& n) {
      double depth = kLeastDepth;
      for (std::uint32_t v : surface_.triangles[of].vertex) {
        depth = std::max(depth, std::abs((surface_.vertices[v] - p).dot(n)));
      }
      thickness_[of] = std::min(thickness_[of], depth);
    };
    most(a, Vertex(surface_.triangles[b], 0), n_b);
    most(b, Vertex(surface_.triangles[a], 0), n_a);
  }

  void AddVertices() {
    for (std::uint32_t v = 0; v < kinds_.size(); ++v) {
      VertexKind& kind = kinds_[v];
      if (kind.longest == 0.0) continue;  // of no triangle
      if (IsSmooth(kind)) {
        // Every place of the surface is nearer than this to one of its triangle's corners.
        kind.reach = 0.6 * kind.longest;
        AddPoint(surface_.vertices[v], {kind.normal, kOpposed}, kind.reach, kind.triangle);
      } else if (kind.convex) {
        const bool all = kind.concave || kind.end;
        AddPoint(surface_.vertices[v], all ? Facing{} : AcrossNormals(kind.normals), kOnCrease,
                 kind.triangle);
      }
    }
  }

  static bool IsSmooth(const VertexKind& kind) { return !kind.sharp && !kind.flat; }

  /// SurfacePoint::m and cosine.
  struct Facing {
    Vec3 outward = Vec3::Zero();
    double cosine = kFacesAnything;
  };

  /// Of a crease or corner where these normals meet.
  static Facing AcrossNormals(const std::vector<Vec3>& normals) {
    Vec3 middle = Vec3::Zero();
    for (const Vec3& n : normals) middle += n;
    if (!(middle.norm() > 0.1 * static_cast<double>(normals.size()))) return {};
    middle.normalize();
    double half = 0.0;
    for (const Vec3& n : normals)
      half = std::max(half, std::acos(std::clamp(n.dot(middle), -1.0, 1.0)));
    return {middle, std::cos(std::min(half + kCreaseSlack, M_PI))};
  }

  void AddPoint(const Vec3& x, const Facing& facing, double reach, std::uint32_t triangle) {
    SurfacePoint point{};
    Put(point.x, x);
    Put(point.m, facing.outward);
    point.cosine = facing.cosine;
    point.reach = reach;
    out_.points.push_back(point);
    const std::uint32_t leaf = leaves_of_.Nearest(surface_.triangles[triangle].source, x);
    out_.point_leaf.push_back(leaf);
    point_pieces.push_back({{x, x, x}, 1e-9, leaf});
  }

  void AddPatches() {
    for (std::uint32_t i = 0; i < surface_.triangles.size(); ++i) {
      const Triangle& t = surface_.triangles[i];
      const Vec3 &p0 = Vertex(t, 0), &p1 = Vertex(t, 1), &p2 = Vertex(t, 2);
      const Vec3 e1 = p1 - p0, e2 = p2 - p0, face = surface_.FaceNormal(i);
      const Vec3 d1 = t.normal[1] - t.normal[0], d2 = t.normal[2] - t.normal[0];
      const bool flat = d1.norm() < kFlat && d2.norm() < kFlat;
      SurfacePatch patch{};
      Put(patch.p0, p0);
      Put(patch.e1, e1);
      Put(patch.e2, e2);
      Put(patch.n0, t.normal[0]);
      Put(patch.d1, d1);
      Put(patch.d2, d2);
      double lift = 0.0;
      for (std::size_t c = 0; c < 3; ++c) {
        patch.lift[2 * c] = e1.dot(t.normal[c]);
        patch.lift[2 * c + 1] = e2.dot(t.normal[c]);
        for (std::size_t other : {(c + 1) % 3, (c + 2) % 3}) {
          lift = std::max(lift, std::abs((Vertex(t, other) - Vertex(t, c)).dot(t.normal[c])));
        }
      }
      const Vec3 middle = (p0 + p1 + p2) / 3.0;
      const double radius =
          std::max({(p0 - middle).norm(), (p1 - middle).norm(), (p2 - middle).norm()});
      patch.reach = flat ? kInfinity : 0.0;
      if (!flat) {
        bool sampled = true;
        for (std::uint32_t v : t.vertex) {
          sampled = sampled && IsSmooth(kinds_[v]);
          patch.reach = std::max(patch.reach, kinds_[v].reach);
        }
        if (!sampled) {
          const Vec3 normal = (t.normal[0] + t.normal[1] + t.normal[2]).normalized();
          Vec3 lifted = middle;
          for (std::size_t c = 0; c < 3; ++c) {
            lifted -= (middle - Vertex(t, c)).dot(t.normal[c]) * t.normal[c] / 6.0;
          }
          patch.reach = std::max(patch.reach, radius);
          AddPoint(lifted, {normal, kOpposed}, radius, i);
        }
        AddMidpoints(i);
      }
      const std::uint32_t leaf = leaves_of_.Nearest(t.source, middle);
      patch.depth =
          std::min(thickness_[i], std::max(leaves_.leaf_radius[leaf], 0.05 * longest_edge_));
      patch.outside = creased_[i] ? kAtCrease : kAcrossEdges;
      out_.patches.push_back(patch);
      out_.patch_leaf.push_back(leaf);
      const double slack = lift / 3.0;  // a third of the largest at most
      patch_pieces.push_back({{p0, p1, p2}, slack, leaf});
      PatchDisc disc{};
      Put(disc.n, face);
      Put(disc.centre, middle);
      disc.slack = slack;
      disc.radius = radius;
      disc.reach = patch.reach;
      out_.discs.push_back(disc);
    }
  }

  /// Points in the middle of a triangle's smooth edges, where they bend; of two triangles the one
  /// that comes first along the edge adds it.
  void AddMidpoints(std::uint32_t triangle) {
    const Triangle& t = surface_.triangles[triangle];
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t d = (c + 1) % 3;
      if (t.vertex[c] > t.vertex[d]) continue;
      const Vec3 half = 0.5 * (Vertex(t, d) - Vertex(t, c));
      const Vec3 lift =
          0.25 * (half.dot(t.normal[d]) * t.normal[d] - half.dot(t.normal[c]) * t.normal[c]);
      if (lift.norm() < kBump) continue;
      AddPoint(Vertex(t, c) + half + lift, {(t.normal[c] + t.normal[d]).normalized(), kOpposed},
               half.norm(), triangle);
    }
  }

  void AddCreases() {
    for (const SurfaceMesh::SharpEdge& edge : surface_.sharp_edges) {
      if (!edge.convex) continue;
      CreaseSegment crease;
      crease.a = surface_.vertices[edge.vertex[0]];
      crease.d = surface_.vertices[edge.vertex[1]] - crease.a;
      const double length = crease.d.norm();
      const Vec3 along = crease.d / length, middle = crease.a + 0.5 * crease.d;
      const auto into = [&](std::uint32_t triangle) -> Vec3 {
        const Triangle& t = surface_.triangles[triangle];
        const Vec3 inside = (Vertex(t, 0) + Vertex(t, 1) + Vertex(t, 2)) / 3.0 - crease.a;
        return (inside - along.dot(inside) * along).normalized();
      };
      crease.t0 = into(edge.triangle[0]);
      crease.t1 = into(edge.triangle[1]);
      out_.creases.push_back(crease);
      out_.crease_leaf.push_back(
          leaves_of_.Nearest(surface_.triangles[edge.triangle[0]].source, middle));
      crease_pieces.push_back(
          {{crease.a, crease.a + crease.d, middle}, 0.0, out_.crease_leaf.back()});
      Facing facing;
      if (edge.triangle[0] != edge.triangle[1]) {
        std::vector<Vec3> normals;
        for (std::uint32_t t : edge.triangle) AppendNormals(t, edge.vertex, normals);
        facing = AcrossNormals(normals);
      }
      for (double at : {0.2, 0.4, 0.6, 0.8}) {
        AddPoint(crease.a + at * crease.d, facing, kOnCrease, edge.triangle[0]);
      }
    }
  }

  double longest_edge_;
  SurfaceMesh surface_;
  const SphereTree& leaves_;
  LeavesOfTriangle leaves_of_;
  ContactSurface& out_;
  std::vector<VertexKind> kinds_;
  std::vector<double> thickness_;  ///< of the body below each triangle, at most [m]
  std::vector<bool> creased_;      ///< of each triangle: whether one of its edges is a crease
};

template <class T>
void Sort(const std::vector<std::uint32_t>& order, std::vector<T>& values) {
  std::vector<T> sorted;
  sorted.reserve(values.size());
  for (std::uint32_t i : order) sorted.push_back(values[i]);
  values = std::move(sorted);
}

}  // namespace

ContactSurface::ContactSurface(const TriangleMesh& mesh, const SphereTree& leaves,
                               const Pose& X_FB) {
  SurfaceBuilder builder(mesh, leaves, *this);
  const Mat3 R = X_FB.q.toRotationMatrix();
  const auto turn = [&](double* v) { Put(v, R * Vec3(v[0], v[1], v[2])); };
  const auto move = [&](double* v) { Put(v, R * Vec3(v[0], v[1], v[2]) + X_FB.p); };
  for (SurfacePoint& point : points) {
    move(point.x);
    turn(point.m);
  }
  for (SurfacePatch& patch : patches) {
    move(patch.p0);
    for (double* v : {patch.e1, patch.e2, patch.n0, patch.d1, patch.d2}) turn(v);
    PatchDisc& disc = discs[static_cast<std::size_t>(&patch - patches.data())];
    turn(disc.n);
    move(disc.centre);
    disc.offset =
        Vec3(disc.n[0], disc.n[1], disc.n[2]).dot(Vec3(patch.p0[0], patch.p0[1], patch.p0[2]));
  }
  for (CreaseSegment& crease : creases) {
    crease.a = R * crease.a + X_FB.p;
    for (Vec3* v : {&crease.d, &crease.t0, &crease.t1}) *v = R * *v;
  }
  const auto arrange = [&](std::vector<SurfacePiece>& pieces, SphereTree& tree, auto&... values) {
    for (SurfacePiece& piece : pieces) {
      for (Vec3& corner : piece.corner) corner = R * corner + X_FB.p;
    }
    std::vector<std::uint32_t> order;
    tree = MakeSurfaceTree(leaves, X_FB, pieces, order);
    (Sort(order, values), ...);
  };
  arrange(builder.point_pieces, point_tree, points, point_leaf);
  arrange(builder.patch_pieces, patch_tree, patches, discs, patch_leaf);
  arrange(builder.crease_pieces, crease_tree, creases, crease_leaf);
}

}  // namespace palpate
