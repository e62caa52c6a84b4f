#include "server/physics/surface/contact_mesh.h"

#include <algorithm>
#include <numeric>

#include "common/math/sort_by_number.h"

namespace palpate {
namespace {

/// Tolerance of the cone tests.  Directions between points at least 1e-7 m apart are known to 1e-15
/// / 1e-7 = 1e-8 (coordinates of a metre are rounded to 1e-16); a hundred times that.
constexpr double kConeSlack = 1e-6;

/// Two triangles that meet at a greater angle than this, 40 degrees, form a crease.  Taken.
constexpr double kCreaseCosine = 0.766;

Vec3 UnitOrZero(const Vec3& v) {
  const double length = v.norm();
  return length > 0.0 ? Vec3(v / length) : Vec3(Vec3::Zero());
}

/// Returns whether a way along the mesh leads nearer.
bool LeadsTo(const Vec3& n, const Vec3& way) {
  return way.dot(n) > 0.0 && UnitOrZero(way).dot(n) > kConeSlack;
}

std::uint32_t CornerOf(const ContactMesh::Triangle& t, std::uint32_t vertex) {
  return t.vertex[0] == vertex ? 0 : t.vertex[1] == vertex ? 1 : 2;
}

}  // namespace

ContactMesh::ContactMesh(const TriangleMesh& mesh, const Vec3& origin) {
  Weld(mesh, origin);
  Scratch scratch;
  Connect(scratch);
}

void ContactMesh::KeepNormals() {
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) normals_.push_back(CornerNormals(t));
}

void ContactMesh::Reserve(std::size_t triangles) {
  ReserveEach(triangles + 1, vertices_, triangles_, vertex_begin_);
  ReserveEach(3 * triangles + 1, edge_begin_, edge_faces_, vertex_faces_);
}

void ContactMesh::Scratch::Reserve(std::size_t triangles) {
  ReserveEach(3 * triangles, sides, sorted);
  ReserveEach(triangles + 1, place, faces);
}

void ContactMesh::Assign(std::span<const Vec3> vertices,
                         std::span<const std::array<std::uint32_t, 3>> triangles,
                         Scratch& scratch) {
  vertices_.assign(vertices.begin(), vertices.end());
  triangles_.clear();
  edge_begin_.assign(1, 0);
  edge_faces_.clear();
  reach_ = 0.0;
  for (const auto& triangle : triangles) AddTriangle(triangle);
  Connect(scratch);
}

ContactMesh ContactMesh::Point() {
  ContactMesh point;
  point.vertices_.push_back(Vec3::Zero());
  point.triangles_.push_back({{0, 0, 0}, {0, 0, 0}, Vec3::Zero()});
  // A ball can touch in any direction: no edge and no neighbour bounds its cone.
  point.edge_begin_ = {0, 0};
  point.vertex_begin_ = {0, 0};
  return point;
}

/// Merges vertices at the same place, so that neighbours are found.
void ContactMesh::Weld(const TriangleMesh& mesh, const Vec3& origin) {
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
      vertices_.push_back(mesh.vertices[order[i]] - origin);
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
      reach_ = std::max(reach_, vertices_[a].squaredNorm());
    }
  }
  reach_ = std::sqrt(reach_);
  const SortRoom<Scratch::Side> room{scratch.sorted, scratch.place};
  SortByNumber(sides, vertices_.size(), &Scratch::Side::high, room);
  SortByNumber(sides, vertices_.size(), &Scratch::Side::low, room);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const Scratch::Side& side = sides[i];
    if (i > 0 && (side.low != sides[i - 1].low || side.high != sides[i - 1].high)) {
      edge_begin_.push_back(static_cast<std::uint32_t>(i));
    }
    triangles_[side.triangle].edge[side.corner] =
        static_cast<std::uint32_t>(edge_begin_.size() - 1);
    edge_faces_.push_back(side.triangle);
  }
  if (!sides.empty()) edge_begin_.push_back(static_cast<std::uint32_t>(sides.size()));

  std::partial_sum(faces.begin(), faces.end(), faces.begin());
  vertex_begin_ = faces;
  vertex_faces_.resize(faces.back());
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    for (const std::uint32_t vertex : triangles_[t].vertex) vertex_faces_[faces[vertex]++] = t;
  }
}

/// Returns the triangle across the edge from a corner to the next if there is one and no crease
/// lies between; otherwise the triangle itself.
std::uint32_t ContactMesh::Across(std::uint32_t triangle, std::uint32_t corner) const {
  const Triangle& t = triangles_[triangle];
  const auto faces = FacesAtEdge(t.edge[corner]);
  if (faces.size() != 2) return triangle;
  const std::uint32_t across = faces[0] == triangle ? faces[1] : faces[0];
  const Triangle& other = triangles_[across];
  const std::uint32_t b = t.vertex[(corner + 1) % 3];
  const bool winds_alike = other.vertex[(CornerOf(other, b) + 1) % 3] == t.vertex[corner];
  return winds_alike && t.normal.dot(other.normal) >= kCreaseCosine ? across : triangle;
}

/// Corners at a vertex that no crease separates share a normal: the mean of the faces' normals with
/// the weights of Max (J. Graphics Tools 4 (1999) 1-6), which are exact on a sphere.
std::array<Eigen::Vector3f, 3> ContactMesh::CornerNormals(std::uint32_t triangle) const {
  std::array<Eigen::Vector3f, 3> normals;
  const Triangle& t = triangles_[triangle];
  for (std::uint32_t c = 0; c < 3; ++c) {
    const std::uint32_t vertex = t.vertex[c];
    Vec3 sum = Vec3::Zero();
    const auto add = [&](std::uint32_t face) {
      const auto& v = triangles_[face].vertex;
      const std::uint32_t at = CornerOf(triangles_[face], vertex);
      const Vec3 a = vertices_[v[(at + 1) % 3]] - vertices_[vertex];
      const Vec3 b = vertices_[v[(at + 2) % 3]] - vertices_[vertex];
      const double weight = a.squaredNorm() * b.squaredNorm();
      if (weight > 0.0) sum += a.cross(b) / weight;
    };
    // Goes round the vertex one way until a crease, a border or the start, and then the other way.
    std::uint32_t first = triangle;
    add(triangle);
    for (const std::uint32_t behind : {2u, 0u}) {
      std::uint32_t face = triangle;
      while (true) {
        const std::uint32_t next = Across(face, (CornerOf(triangles_[face], vertex) + behind) % 3);
        if (next == face || next == first) break;
        add(face = next);
      }
      first = face;
    }
    const Vec3 n = UnitOrZero(sum);
    // If the sum differs from the triangle's own normal by as much as a crease,
    // the triangle's is used.
    normals[c] = (n.dot(t.normal) >= kCreaseCosine ? n : t.normal).cast<float>();
  }
  return normals;
}

Vec3 ContactMesh::SmoothNormal(std::uint32_t triangle, const Vec3& place, const Vec3& n) const {
  const Triangle& t = triangles_[triangle];
  const Vec3& a = vertices_[t.vertex[0]];
  const Vec3 u = vertices_[t.vertex[1]] - a, w = vertices_[t.vertex[2]] - a, r = place - a;
  const double uu = u.dot(u), uw = u.dot(w), ww = w.dot(w), ur = u.dot(r), wr = w.dot(r);
  const double across = uu * ww - uw * uw;
  if (!(across > 0.0)) return n;
  const double y = (ww * ur - uw * wr) / across, z = (uu * wr - uw * ur) / across;
  const auto normal = normals_.empty() ? CornerNormals(triangle) : normals_[triangle];
  const Vec3 smooth = UnitOrZero((1.0 - y - z) * normal[0].cast<double>() +
                                 y * normal[1].cast<double>() + z * normal[2].cast<double>());
  // If the corners' normals differ from the triangle's own by at most the angle a, the triangle
  // meets its neighbours at about 2 a.  On a smooth surface, the direction n of a touch here or
  // nearby then lies within twice that, 4 a.  Beyond, it belongs to a crease.
  const double side = n.dot(smooth) < 0.0 ? -1.0 : 1.0;
  double bend = 1.0;
  for (const auto& corner : normal) bend = std::min(bend, t.normal.dot(corner.cast<double>()));
  const double twice = 2.0 * bend * bend - 1.0;
  const bool within = side * n.dot(t.normal) >= 2.0 * twice * twice - 1.0 - kConeSlack;
  return within ? Vec3(side * smooth) : n;
}

bool ContactMesh::EdgeConeHolds(std::uint32_t edge, const Vec3& n) const {
  const Vec3* low = nullptr;
  Vec3 along;
  for (const std::uint32_t face : FacesAtEdge(edge)) {
    const Triangle& t = triangles_[face];
    const std::size_t c = t.edge[0] == edge ? 0 : t.edge[1] == edge ? 1 : 2;
    if (low == nullptr) {
      const auto [first, second] = std::minmax(t.vertex[c], t.vertex[(c + 1) % 3]);
      low = &vertices_[first];
      along = UnitOrZero(vertices_[second] - *low);
    }
    const Vec3 inside = vertices_[t.vertex[(c + 2) % 3]] - *low;
    if (LeadsTo(n, inside - inside.dot(along) * along)) return false;
  }
  return true;
}

bool ContactMesh::VertexConeHolds(std::uint32_t vertex, const Vec3& n) const {
  for (const std::uint32_t face : FacesAtVertex(vertex)) {
    for (const std::uint32_t end : triangles_[face].vertex) {
      if (LeadsTo(n, vertices_[end] - vertices_[vertex])) return false;
    }
  }
  return true;
}

}  // namespace palpate
