#include "server/physics/surface/contact_mesh.h"

#include <algorithm>
#include <numeric>

#include "common/math/sort_by_number.h"

namespace palpate {
namespace {

/// Slack of the cone tests.  Directions between points 1e-7 m apart or more are known to
/// 1e-15 / 1e-7 = 1e-8 (coordinates of a metre are rounded to 1e-16); times a hundred.
constexpr double kConeSlack = 1e-6;

/// Two triangles that meet at a greater angle than this, 40 degrees, meet in a crease: taken.
constexpr double kCreaseCosine = 0.766;

bool Holds(const Vec3* direction, std::size_t count, const Vec3& n) {
  for (std::size_t i = 0; i < count; ++i) {
    if (direction[i].dot(n) > kConeSlack) return false;
  }
  return true;
}

Vec3 UnitOrZero(const Vec3& v) {
  const double length = v.norm();
  return length > 0.0 ? Vec3(v / length) : Vec3(Vec3::Zero());
}

}  // namespace

ContactMesh::ContactMesh(const TriangleMesh& mesh, const Pose& X_FB) {
  Weld(mesh, X_FB);
  Scratch scratch;
  Connect(scratch);
  SetNormals(scratch);
}

void ContactMesh::Reserve(std::size_t triangles) {
  const std::size_t corners = 3 * triangles;
  vertices_.reserve(triangles);
  triangles_.reserve(triangles);
  edge_begin_.reserve(corners + 1);
  edge_faces_.reserve(corners);
  edge_directions_.reserve(corners);
  vertex_begin_.reserve(triangles + 1);
  vertex_faces_.reserve(corners);
  vertex_directions_.reserve(2 * corners);
  normals_.reserve(triangles);
}

void ContactMesh::Scratch::Reserve(std::size_t triangles) {
  const std::size_t corners = 3 * triangles;
  sides.reserve(corners);
  sorted.reserve(corners);
  place.reserve(triangles + 1);
  faces.reserve(triangles + 1);
  parent.reserve(corners);
  sum.reserve(corners);
}

void ContactMesh::Assign(std::span<const Vec3> vertices,
                         std::span<const std::array<std::uint32_t, 3>> triangles, const Pose& X_FB,
                         Scratch& scratch) {
  vertices_.clear();
  triangles_.clear();
  edge_begin_.assign(1, 0);
  edge_faces_.clear();
  edge_directions_.clear();
  reach_ = 0.0;
  for (const Vec3& v : vertices) vertices_.push_back(X_FB * v);
  for (const auto& triangle : triangles) AddTriangle(triangle);
  Connect(scratch);
  SetNormals(scratch);
}

ContactMesh ContactMesh::Point() {
  ContactMesh point;
  point.vertices_.push_back(Vec3::Zero());
  point.triangles_.push_back({{0, 0, 0}, {0, 0, 0}, Vec3::Zero()});
  // A ball can touch in any direction: no edge and no neighbour bounds its cone.
  point.edge_begin_ = {0, 0};
  point.vertex_begin_ = {0, 0};
  point.normals_.resize(1);
  return point;
}

/// Vertices of the same place become one, so that neighbours are known as such.
void ContactMesh::Weld(const TriangleMesh& mesh, const Pose& X_FB) {
  std::vector<std::uint32_t> order(mesh.vertices.size()), welded(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t i) {
    const Vec3& v = mesh.vertices[i];
    return std::array<double, 3>{v.x(), v.y(), v.z()};
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return key(a) != key(b) ? key(a) < key(b) : a < b;
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || key(order[i]) != key(order[i - 1])) {
      vertices_.push_back(X_FB * mesh.vertices[order[i]]);
    }
    welded[order[i]] = static_cast<std::uint32_t>(vertices_.size() - 1);
  }
  for (const auto& [i, j, k] : mesh.triangles) AddTriangle({welded[i], welded[j], welded[k]});
}

void ContactMesh::AddTriangle(const std::array<std::uint32_t, 3>& vertex) {
  const auto& [i, j, k] = vertex;
  const Vec3 across = (vertices_[j] - vertices_[i]).cross(vertices_[k] - vertices_[i]);
  triangles_.push_back({vertex, {}, UnitOrZero(across)});
}

void ContactMesh::Connect(Scratch& scratch) {
  std::vector<Scratch::Side>& sides = scratch.sides;  // by edge, then by triangle
  sides.clear();
  std::vector<std::uint32_t>& faces = scratch.faces;
  faces.assign(vertices_.size() + 1, 0);
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const auto& v = triangles_[t].vertex;
    for (std::uint32_t c = 0; c < 3; ++c) {
      const std::uint32_t a = v[c], b = v[(c + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), t, c});
      ++faces[a + 1];
      reach_ = std::max(reach_, vertices_[a].norm());
    }
  }
  const SortRoom<Scratch::Side> room{scratch.sorted, scratch.place};
  SortByNumber(sides, vertices_.size(), &Scratch::Side::high, room);
  SortByNumber(sides, vertices_.size(), &Scratch::Side::low, room);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const Scratch::Side& side = sides[i];
    if (i > 0 && (side.low != sides[i - 1].low || side.high != sides[i - 1].high)) {
      edge_begin_.push_back(static_cast<std::uint32_t>(i));
    }
    Triangle& t = triangles_[side.triangle];
    t.edge[side.corner] = static_cast<std::uint32_t>(edge_begin_.size() - 1);
    const Vec3& a = vertices_[side.low];
    const Vec3 along = UnitOrZero(vertices_[side.high] - a);
    const Vec3 inside = vertices_[t.vertex[(side.corner + 2) % 3]] - a;
    edge_faces_.push_back(side.triangle);
    edge_directions_.push_back(UnitOrZero(inside - inside.dot(along) * along));
  }
  if (!sides.empty()) edge_begin_.push_back(static_cast<std::uint32_t>(sides.size()));

  std::partial_sum(faces.begin(), faces.end(), faces.begin());
  vertex_begin_ = faces;
  vertex_faces_.resize(faces.back());
  vertex_directions_.resize(2 * vertex_faces_.size());
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const auto& v = triangles_[t].vertex;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t at = faces[v[c]]++;
      vertex_faces_[at] = t;
      for (std::size_t k = 1; k < 3; ++k) {
        vertex_directions_[2 * at + k - 1] =
            UnitOrZero(vertices_[v[(c + k) % 3]] - vertices_[v[c]]);
      }
    }
  }
}

/// Corners of a vertex that no crease separates share a normal: the faces' with the weights of Max
/// (J. Graphics Tools 4 (1999) 1-6), which are exact on a sphere.
void ContactMesh::SetNormals(Scratch& scratch) {
  const auto corner_of = [&](std::uint32_t t, std::uint32_t vertex) {
    const auto& v = triangles_[t].vertex;
    return 3 * t + (v[0] == vertex ? 0u : v[1] == vertex ? 1u : 2u);
  };
  std::vector<std::uint32_t>& parent = scratch.parent;
  parent.resize(3 * triangles_.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto faces = FacesAtEdge(triangles_[t].edge[c]);
      if (faces.size() != 2 || faces[0] != t) continue;
      const std::uint32_t other = faces[1];
      const std::uint32_t a = triangles_[t].vertex[c], b = triangles_[t].vertex[(c + 1) % 3];
      const auto& v = triangles_[other].vertex;
      const bool winds_alike = v[(corner_of(other, b) % 3 + 1) % 3] == a;
      if (!winds_alike || triangles_[t].normal.dot(triangles_[other].normal) < kCreaseCosine) {
        continue;
      }
      for (const std::uint32_t vertex : {a, b}) {
        parent[root(corner_of(t, vertex))] = root(corner_of(other, vertex));
      }
    }
  }
  std::vector<Vec3>& sum = scratch.sum;
  sum.assign(parent.size(), Vec3::Zero());
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const auto& v = triangles_[t].vertex;
      const Vec3 a = vertices_[v[(c + 1) % 3]] - vertices_[v[c]];
      const Vec3 b = vertices_[v[(c + 2) % 3]] - vertices_[v[c]];
      const double weight = a.squaredNorm() * b.squaredNorm();
      if (weight > 0.0) sum[root(3 * t + c)] += a.cross(b) / weight;
    }
  }
  normals_.resize(triangles_.size());
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Vec3 n = UnitOrZero(sum[root(3 * t + c)]);
      // Where the sum leaves the triangle's own normal as far as a crease, it keeps its own.
      const bool smooth = n.dot(triangles_[t].normal) >= kCreaseCosine;
      normals_[t][c] = (smooth ? n : triangles_[t].normal).cast<float>();
    }
  }
}

Vec3 ContactMesh::SmoothNormal(std::uint32_t triangle, const Vec3& place, const Vec3& n) const {
  const Triangle& t = triangles_[triangle];
  const Vec3& a = vertices_[t.vertex[0]];
  const Vec3 u = vertices_[t.vertex[1]] - a, w = vertices_[t.vertex[2]] - a, r = place - a;
  const double uu = u.dot(u), uw = u.dot(w), ww = w.dot(w), ur = u.dot(r), wr = w.dot(r);
  const double across = uu * ww - uw * uw;
  if (!(across > 0.0)) return n;
  const double y = (ww * ur - uw * wr) / across, z = (uu * wr - uw * ur) / across;
  const auto& normal = normals_[triangle];
  const Vec3 smooth = UnitOrZero((1.0 - y - z) * normal[0].cast<double>() +
                                 y * normal[1].cast<double>() + z * normal[2].cast<double>());
  // Say the corners' normals leave the triangle's own by the angle a at most.  Then it meets its
  // neighbours at about 2 a, and on a smooth surface the direction n of a touch here or beside lies
  // within twice that, 4 a.  Beyond, it is a crease's.
  const double side = n.dot(smooth) < 0.0 ? -1.0 : 1.0;
  double bend = 1.0;
  for (const auto& corner : normal) bend = std::min(bend, t.normal.dot(corner.cast<double>()));
  const double twice = 2.0 * bend * bend - 1.0;
  const bool within = side * n.dot(t.normal) >= 2.0 * twice * twice - 1.0 - kConeSlack;
  return within ? Vec3(side * smooth) : n;
}

bool ContactMesh::EdgeConeHolds(std::uint32_t edge, const Vec3& n) const {
  return Holds(edge_directions_.data() + edge_begin_[edge],
               edge_begin_[edge + 1] - edge_begin_[edge], n);
}

bool ContactMesh::VertexConeHolds(std::uint32_t vertex, const Vec3& n) const {
  return Holds(vertex_directions_.data() + 2 * vertex_begin_[vertex],
               2 * (vertex_begin_[vertex + 1] - vertex_begin_[vertex]), n);
}

}  // namespace palpate
