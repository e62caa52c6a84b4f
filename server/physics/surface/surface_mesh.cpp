#include "server/physics/surface/surface_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace palpate {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

Edge EdgeOf(std::uint32_t a, std::uint32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

/// One side of an edge: corner `corner` of a triangle is where it starts.
struct HalfEdge {
  Edge edge;
  std::uint32_t triangle;
  std::uint32_t corner;
};

std::vector<HalfEdge> SortedHalfEdges(const std::vector<SurfaceMesh::Triangle>& triangles) {
  std::vector<HalfEdge> halves;
  halves.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const auto& v = triangles[t].vertex;
      halves.push_back({EdgeOf(v[c], v[(c + 1) % 3]), t, c});
    }
  }
  std::sort(halves.begin(), halves.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.triangle < b.triangle;
  });
  return halves;
}

/// Calls visit(first, last) for the half-edges of each edge.
template <class Visit>
void ForEachEdge(const std::vector<HalfEdge>& halves, Visit visit) {
  for (std::size_t i = 0; i < halves.size();) {
    std::size_t end = i + 1;
    while (end < halves.size() && halves[end].edge == halves[i].edge) ++end;
    visit(&halves[i], &halves[0] + end);
    i = end;
  }
}

class Builder {
 public:
  Builder(const TriangleMesh& mesh, SurfaceMesh& out) : out_(out) {
    Weld(mesh);
    DropBackToBack();
    FindSharpEdges();
    SetNormals();
  }

  /// Halves every edge that is longer than that; false where there was none.
  bool Refine(double longest_edge) {
    struct Midpoint {
      Edge edge;
      std::uint32_t vertex;
    };
    std::vector<Midpoint> midpoints;
    ForEachEdge(SortedHalfEdges(out_.triangles), [&](const HalfEdge* first, const HalfEdge*) {
      const auto& [a, b] = first->edge;
      if ((out_.vertices[a] - out_.vertices[b]).norm() <= longest_edge) return;
      const auto& t = out_.triangles[first->triangle];
      const std::uint32_t c = first->corner, d = (c + 1) % 3;
      Vec3 middle = 0.5 * (out_.vertices[a] + out_.vertices[b]);
      if (!IsSharp(first->edge)) {
        // The patch's edge depends on its two ends alone: the same from either side.
        const Vec3 half = middle - out_.vertices[t.vertex[c]];
        middle -=
            0.25 * (half.dot(t.normal[c]) * t.normal[c] - half.dot(t.normal[d]) * t.normal[d]);
      }
      midpoints.push_back({first->edge, static_cast<std::uint32_t>(out_.vertices.size())});
      out_.vertices.push_back(middle);
    });
    if (midpoints.empty()) return false;
    const auto middle_of = [&](std::uint32_t a, std::uint32_t b) -> const Midpoint* {
      const Edge edge = EdgeOf(a, b);
      const auto it = std::lower_bound(midpoints.begin(), midpoints.end(), edge,
                                       [](const Midpoint& m, const Edge& e) { return m.edge < e; });
      return it != midpoints.end() && it->edge == edge ? &*it : nullptr;
    };
    std::vector<Edge> sharp;
    for (const Edge& edge : sharp_) {
      if (const Midpoint* m = middle_of(edge.first, edge.second)) {
        sharp.push_back(EdgeOf(edge.first, m->vertex));
        sharp.push_back(EdgeOf(m->vertex, edge.second));
      } else {
        sharp.push_back(edge);
      }
    }
    std::sort(sharp.begin(), sharp.end());
    sharp_ = std::move(sharp);

    std::vector<SurfaceMesh::Triangle> halved;
    halved.reserve(2 * out_.triangles.size());
    for (const SurfaceMesh::Triangle& t : out_.triangles) {
      const Midpoint* m[3];
      for (std::uint32_t c = 0; c < 3; ++c) m[c] = middle_of(t.vertex[c], t.vertex[(c + 1) % 3]);
      Split(t, m, halved);
    }
    out_.triangles = std::move(halved);
    return true;
  }

  void ListSharpEdges() {
    ForEachEdge(SortedHalfEdges(out_.triangles), [&](const HalfEdge* first, const HalfEdge* last) {
      if (!IsSharp(first->edge)) return;
      const HalfEdge& other = *(last - 1);
      SurfaceMesh::SharpEdge edge{
          {first->edge.first, first->edge.second}, {first->triangle, other.triangle}, true};
      if (last - first == 2) {
        const auto& v = out_.triangles[other.triangle].vertex;
        const Vec3 beyond =
            out_.vertices[v[(other.corner + 2) % 3]] - out_.vertices[v[other.corner]];
        edge.convex = beyond.dot(out_.FaceNormal(first->triangle)) < 0.0;
      }
      out_.sharp_edges.push_back(edge);
    });
  }

 private:
  /// Vertices of the same place become one; triangles without area go.
  void Weld(const TriangleMesh& mesh) {
    std::vector<std::uint32_t> order(mesh.vertices.size()), new_index(mesh.vertices.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t i) {
      const Vec3& v = mesh.vertices[i];
      return std::array<double, 3>{v.x(), v.y(), v.z()};
    };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return key(a) != key(b) ? key(a) < key(b) : a < b;
    });
    for (std::size_t i = 0; i < order.size(); ++i) {
      const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
      if (!same) out_.vertices.push_back(mesh.vertices[order[i]]);
      new_index[order[i]] = static_cast<std::uint32_t>(out_.vertices.size() - 1);
    }
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      SurfaceMesh::Triangle triangle{};
      for (std::size_t c = 0; c < 3; ++c) triangle.vertex[c] = new_index[mesh.triangles[t][c]];
      triangle.source = t;
      const auto& v = triangle.vertex;
      const Vec3 a = out_.vertices[v[1]] - out_.vertices[v[0]];
      const Vec3 b = out_.vertices[v[2]] - out_.vertices[v[0]];
      const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (a - b).squaredNorm()});
      if (a.cross(b).norm() > 1e-9 * longest) out_.triangles.push_back(triangle);
    }
  }

  /// Scans have pairs of triangles with the same corners, back to back: a fin with nothing inside,
  /// of which either side is below the other.  They go, and their neighbours meet where they stood.
  void DropBackToBack() {
    const auto& triangles = out_.triangles;
    const auto corners = [&](std::uint32_t t) {
      auto v = triangles[t].vertex;
      std::sort(v.begin(), v.end());
      return v;
    };
    const auto winds_up = [&](std::uint32_t t) {
      const auto& v = triangles[t].vertex;
      const auto least = static_cast<std::size_t>(std::min_element(v.begin(), v.end()) - v.begin());
      return v[(least + 1) % 3] < v[(least + 2) % 3];
    };
    std::vector<std::uint32_t> order(triangles.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return corners(a) < corners(b); });
    std::vector<bool> gone(triangles.size());
    for (std::size_t i = 0; i < order.size();) {
      std::size_t end = i + 1, first_up = order.size(), first_down = order.size();
      while (end < order.size() && corners(order[end]) == corners(order[i])) ++end;
      for (; i < end; ++i) {
        std::size_t& first = winds_up(order[i]) ? first_up : first_down;
        gone[order[i]] = first != order.size();  // one of each
        if (first == order.size()) first = i;
      }
      if (first_up != order.size() && first_down != order.size()) {
        gone[order[first_up]] = gone[order[first_down]] = true;
      }
    }
    std::vector<SurfaceMesh::Triangle> kept;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      if (!gone[t]) kept.push_back(triangles[t]);
    }
    out_.triangles = std::move(kept);
  }

  void FindSharpEdges() {
    halves_ = SortedHalfEdges(out_.triangles);
    ForEachEdge(halves_, [&](const HalfEdge* first, const HalfEdge* last) {
      bool sharp = last - first != 2;
      if (!sharp) {
        const HalfEdge &a = first[0], &b = first[1];
        // Neighbours that wind against each other share no side.
        sharp = out_.triangles[a.triangle].vertex[a.corner] ==
                    out_.triangles[b.triangle].vertex[b.corner] ||
                out_.FaceNormal(a.triangle).dot(out_.FaceNormal(b.triangle)) < kCreaseCosine;
      }
      if (sharp) sharp_.push_back(first->edge);
    });
  }

  bool IsSharp(const Edge& edge) const {
    return std::binary_search(sharp_.begin(), sharp_.end(), edge);
  }

  /// Corners of a vertex that no crease separates share a normal: the faces' with the weights of
  /// Max (J. Graphics Tools 4 (1999) 1-6), which are exact on a sphere.
  void SetNormals() {
    std::vector<std::uint32_t> parent(3 * out_.triangles.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t i) {
      while (parent[i] != i) i = parent[i] = parent[parent[i]];
      return i;
    };
    ForEachEdge(halves_, [&](const HalfEdge* first, const HalfEdge*) {
      if (IsSharp(first->edge)) return;
      const HalfEdge &a = first[0], &b = first[1];
      // a starts where b ends.
      parent[root(3 * a.triangle + a.corner)] = root(3 * b.triangle + (b.corner + 1) % 3);
      parent[root(3 * a.triangle + (a.corner + 1) % 3)] = root(3 * b.triangle + b.corner);
    });
    std::vector<Vec3> sum(parent.size(), Vec3::Zero());
    for (std::uint32_t t = 0; t < out_.triangles.size(); ++t) {
      for (std::uint32_t c = 0; c < 3; ++c) {
        const auto& v = out_.triangles[t].vertex;
        const Vec3 a = out_.vertices[v[(c + 1) % 3]] - out_.vertices[v[c]];
        const Vec3 b = out_.vertices[v[(c + 2) % 3]] - out_.vertices[v[c]];
        sum[root(3 * t + c)] += a.cross(b) / (a.squaredNorm() * b.squaredNorm());
      }
    }
    for (std::uint32_t t = 0; t < out_.triangles.size(); ++t) {
      const Vec3 face = out_.FaceNormal(t);
      for (std::uint32_t c = 0; c < 3; ++c) {
        const Vec3 n = sum[root(3 * t + c)].normalized();
        // Where the surface is crumpled, the triangle stays flat there.
        out_.triangles[t].normal[c] = n.dot(face) > 0.85 ? n : face;
      }
    }
  }

  /// Splits a triangle at the midpoints that its edges have: m[c] is that of corners c and c + 1.
  template <class Midpoint>
  static void Split(const SurfaceMesh::Triangle& t, const Midpoint* const m[3],
                    std::vector<SurfaceMesh::Triangle>& out) {
    struct Corner {
      std::uint32_t vertex;
      Vec3 normal;
    };
    // The outline with its midpoints; triangles are cut off at the ears that no split edge crosses.
    std::vector<Corner> outline;
    std::vector<bool> middle;
    for (std::size_t c = 0; c < 3; ++c) {
      outline.push_back({t.vertex[c], t.normal[c]});
      middle.push_back(false);
      if (m[c] == nullptr) continue;
      outline.push_back({m[c]->vertex, (t.normal[c] + t.normal[(c + 1) % 3]).normalized()});
      middle.push_back(true);
    }
    const auto add = [&](const Corner& a, const Corner& b, const Corner& c) {
      out.push_back({{a.vertex, b.vertex, c.vertex}, {a.normal, b.normal, c.normal}, t.source});
    };
    // A corner between two midpoints is an ear of its own; what is left is a fan.
    while (outline.size() > 3) {
      std::size_t ear = outline.size();
      for (std::size_t i = 0; i < outline.size() && ear == outline.size(); ++i) {
        const std::size_t before = (i + outline.size() - 1) % outline.size();
        const std::size_t after = (i + 1) % outline.size();
        if (!middle[i] && middle[before] && middle[after]) ear = i;
      }
      if (ear == outline.size()) {
        // One midpoint, or two after an ear is gone: cut beside a midpoint.
        for (std::size_t i = 0; i < outline.size(); ++i) {
          if (!middle[i] && middle[(i + 1) % outline.size()]) ear = i;
        }
      }
      const std::size_t before = (ear + outline.size() - 1) % outline.size();
      const std::size_t after = (ear + 1) % outline.size();
      add(outline[before], outline[ear], outline[after]);
      outline.erase(outline.begin() + static_cast<std::ptrdiff_t>(ear));
      middle.erase(middle.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    add(outline[0], outline[1], outline[2]);
  }

  SurfaceMesh& out_;
  std::vector<HalfEdge> halves_;
  std::vector<Edge> sharp_;  ///< sorted
};

}  // namespace

Vec3 SurfaceMesh::FaceNormal(std::size_t triangle) const {
  const auto& v = triangles[triangle].vertex;
  return (vertices[v[1]] - vertices[v[0]]).cross(vertices[v[2]] - vertices[v[0]]).normalized();
}

SurfaceMesh MakeSurfaceMesh(const TriangleMesh& mesh, double longest_edge) {
  SurfaceMesh surface;
  Builder builder(mesh, surface);
  while (builder.Refine(longest_edge)) {
  }
  builder.ListSharpEdges();
  return surface;
}

}  // namespace palpate
