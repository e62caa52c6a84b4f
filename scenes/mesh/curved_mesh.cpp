#include "scenes/mesh/curved_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <utility>

#include "scenes/mesh/disjoint_sets.h"

namespace palpate {
namespace {

/// Triangles that meet at more than 40 degrees form a crease: empirical, as in ContactMesh.
constexpr double kCreaseCosine = 0.766;
/// Sides of a crease whose normals differ by less than 10 degrees do not give its direction,
/// because normals are only accurate to a few degrees.
constexpr double kCreaseSine = 0.17;
/// A triangle whose height is less than this share of its longest edge has no reliable normal:
/// coordinates in files are rounded to 1e-7 of the mesh.
constexpr double kThin = 1e-5;
/// A patch whose normal differs from its triangle's by more than 60 degrees is close to folding.
constexpr double kFoldCosine = 0.5;
/// Faces in a notch of less than 60 degrees stay flat: patches deviate from their triangles by up
/// to 20 degrees on either side, and no plane can separate them where they share a corner.
constexpr double kNotchCosine = -0.5;
/// Limit of the depth of division, which no patch comes near: each level halves an edge.
constexpr int kDeepest = 48;

using Indices = std::vector<std::uint32_t>;

Vec3 UnitOrZero(const Vec3& v) {
  const double length = v.norm();
  return length > 0.0 ? Vec3(v / length) : Vec3(Vec3::Zero());
}

/// Returns for each vertex the first vertex at the same place.
Indices Weld(const std::vector<Vec3>& vertices) {
  Indices order(vertices.size()), first(vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto place = [&](std::uint32_t i) {
    return std::array{vertices[i].x(), vertices[i].y(), vertices[i].z()};
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return place(a) != place(b) ? place(a) < place(b) : a < b;
  });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && place(order[k]) == place(order[k - 1]);
    first[order[k]] = same ? first[order[k - 1]] : order[k];
  }
  return first;
}

/// The mesh as curved patches: the height of the parabola of each edge.
class Patches {
 public:
  explicit Patches(const TriangleMesh& mesh);

  std::size_t edges() const { return rise_.size(); }
  /// Returns the edge from corner c of a triangle to the next.
  std::uint32_t edge(std::uint32_t t, std::size_t c) const { return edge_of_[t][c]; }
  /// Returns the vector from the middle of the edge to that of its parabola [m].
  const Vec3& rise(std::uint32_t e) const { return rise_[e]; }
  /// Returns whether corner c of the triangle is the end from which the edge's points are counted.
  bool Forward(std::uint32_t t, std::size_t c) const {
    return place_of_[mesh_.triangles[t][c]] <= place_of_[mesh_.triangles[t][(c + 1) % 3]];
  }

 private:
  struct Side {
    std::uint32_t low, high, triangle, corner;
  };
  enum class Kind : std::uint8_t { kStraight, kSmooth, kCrease };

  const Vec3& At(std::uint32_t vertex) const { return mesh_.vertices[vertex]; }
  const Vec3& Normal(const Side& side, std::uint32_t place) const;
  void Connect();
  void SetNormals();
  Vec3 Rise(std::uint32_t e) const;
  bool Straighten(std::uint32_t t);
  bool Folds(std::uint32_t t) const;
  std::array<Vec3, 6> Hull(std::uint32_t t) const;
  bool StraightenWherePatchesMeet();

  const TriangleMesh& mesh_;
  Indices place_of_;
  std::vector<Vec3> face_;  ///< unit normals; zero: the triangle is too thin to have one
  std::vector<Side> sides_;
  Indices edge_begin_;  ///< into sides_
  std::vector<Kind> kind_;
  std::vector<std::array<std::uint32_t, 3>> edge_of_;
  std::vector<std::array<Vec3, 3>> normal_;  ///< of the corners
  std::vector<Vec3> rise_;
};

Patches::Patches(const TriangleMesh& mesh) : mesh_(mesh), place_of_(Weld(mesh.vertices)) {
  face_.resize(mesh.triangles.size());
  for (std::uint32_t t = 0; t < face_.size(); ++t) {
    const auto& [i, j, k] = mesh.triangles[t];
    const Vec3 u = At(j) - At(i), v = At(k) - At(j), w = At(i) - At(k);
    const Vec3 across = w.cross(u);
    const double longest = std::max({u.squaredNorm(), v.squaredNorm(), w.squaredNorm()});
    face_[t] = across.norm() > kThin * longest ? UnitOrZero(across) : Vec3(Vec3::Zero());
  }
  Connect();
  SetNormals();
  rise_.resize(kind_.size());
  for (std::uint32_t e = 0; e < rise_.size(); ++e) rise_[e] = Rise(e);

  // An edge that becomes straight affects its neighbours, so repeat until nothing changes.  Each
  // round straightens at least one edge.
  for (bool again = true; again;) {
    again = false;
    for (std::uint32_t t = 0; t < face_.size(); ++t) {
      if (Folds(t)) again |= Straighten(t);
    }
    if (!again) again = StraightenWherePatchesMeet();
  }
}

void Patches::Connect() {
  const auto& triangles = mesh_.triangles;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const std::uint32_t a = place_of_[triangles[t][c]], b = place_of_[triangles[t][(c + 1) % 3]];
      sides_.push_back({std::min(a, b), std::max(a, b), t, c});
    }
  }
  std::sort(sides_.begin(), sides_.end(), [](const Side& a, const Side& b) {
    return std::array{a.low, a.high, a.triangle, a.corner} <
           std::array{b.low, b.high, b.triangle, b.corner};
  });
  edge_of_.resize(triangles.size());
  for (std::uint32_t i = 0; i < sides_.size(); ++i) {
    const Side& side = sides_[i];
    if (i == 0 || side.low != sides_[i - 1].low || side.high != sides_[i - 1].high) {
      edge_begin_.push_back(i);
    }
    edge_of_[side.triangle][side.corner] = static_cast<std::uint32_t>(edge_begin_.size() - 1);
  }
  edge_begin_.push_back(static_cast<std::uint32_t>(sides_.size()));
  for (std::size_t e = 0; e + 1 < edge_begin_.size(); ++e) {
    Kind kind = Kind::kStraight;
    if (edge_begin_[e + 1] - edge_begin_[e] == 2) {
      const Side& a = sides_[edge_begin_[e]];
      const Side& b = sides_[edge_begin_[e] + 1];
      const Vec3 &n = face_[a.triangle], &m = face_[b.triangle];
      const bool wind_alike =
          place_of_[triangles[a.triangle][a.corner]] != place_of_[triangles[b.triangle][b.corner]];
      if (wind_alike && !n.isZero(0.0) && !m.isZero(0.0)) {
        kind = n.dot(m) < kCreaseCosine ? Kind::kCrease : Kind::kSmooth;
      }
    }
    kind_.push_back(kind);
  }
}

/// Corners at a place that no crease separates share a normal: that of the faces with the weights
/// of Max (J. Graphics Tools 4 (1999) 1-6), which are exact on a sphere.
void Patches::SetNormals() {
  const auto& triangles = mesh_.triangles;
  const auto corner_at = [&](std::uint32_t t, std::uint32_t place) {
    const auto& v = triangles[t];
    return 3 * t + (place_of_[v[0]] == place ? 0u : place_of_[v[1]] == place ? 1u : 2u);
  };
  DisjointSets corners(3 * triangles.size());
  for (std::size_t e = 0; e < kind_.size(); ++e) {
    if (kind_[e] != Kind::kSmooth) continue;
    const Side& a = sides_[edge_begin_[e]];
    const Side& b = sides_[edge_begin_[e] + 1];
    for (const std::uint32_t place : {a.low, a.high}) {
      corners.Join(corner_at(a.triangle, place), corner_at(b.triangle, place));
    }
  }
  std::vector<Vec3> sum(3 * triangles.size(), Vec3::Zero());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (face_[t].isZero(0.0)) continue;
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Vec3 u = At(triangles[t][(c + 1) % 3]) - At(triangles[t][c]);
      const Vec3 v = At(triangles[t][(c + 2) % 3]) - At(triangles[t][c]);
      sum[corners.Find(3 * t + c)] += u.cross(v) / (u.squaredNorm() * v.squaredNorm());
    }
  }
  normal_.resize(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (std::uint32_t c = 0; c < 3; ++c) normal_[t][c] = UnitOrZero(sum[corners.Find(3 * t + c)]);
  }
}

const Vec3& Patches::Normal(const Side& side, std::uint32_t place) const {
  const bool first = place_of_[mesh_.triangles[side.triangle][side.corner]] == place;
  return normal_[side.triangle][first ? side.corner : (side.corner + 1) % 3];
}

/// Returns how far the middle of an edge rises to its curve; zero: the edge is straight.
///
///   turn  a .-----. b     The part by which the tangents turn towards each other bends the edge;
///   lean  a .-. ,-' b     the part by which they turn alike is an inflection.
///
/// On a smooth surface the lean is small compared with the turn if edges are short.  Noise at the
/// corners contributes equally to both.  So an edge that leans by more than half of its turn is
/// bent less, and one that leans as much as it turns is not bent.
Vec3 Patches::Rise(std::uint32_t e) const {
  const Vec3 straight = Vec3::Zero();
  if (kind_[e] == Kind::kStraight) return straight;
  const Side& a = sides_[edge_begin_[e]];
  const Side& b = sides_[edge_begin_[e] + 1];
  const Vec3 chord = At(a.high) - At(a.low);
  const double length = chord.norm();
  const Vec3 along = chord / length;
  std::array<Vec3, 2> tangent;
  for (const int end : {0, 1}) {
    const std::uint32_t place = end == 0 ? a.low : a.high;
    const Vec3 &n = Normal(a, place), &m = Normal(b, place);
    for (const auto& [side, normal] : {std::pair(&a, &n), std::pair(&b, &m)}) {
      // A normal that differs from the face's as much as at a crease belongs to no smooth surface.
      if (normal->dot(face_[side->triangle]) < kCreaseCosine) return straight;
    }
    Vec3 t = along - along.dot(n) * n;
    if (kind_[e] == Kind::kCrease) {
      t = n.cross(m);
      if (t.norm() < kCreaseSine) return straight;
      if (t.dot(along) < 0.0) t = -t;
    }
    tangent[static_cast<std::size_t>(end)] = UnitOrZero(t);
  }
  if (tangent[0].dot(tangent[1]) < kCreaseCosine || tangent[0].dot(along) < kCreaseCosine ||
      tangent[1].dot(along) < kCreaseCosine) {
    return straight;
  }
  // Half of the turn, as its sine.  A circular arc over the chord L with the half angle phi has the
  // height L/2 tan(phi/2).
  Vec3 turn = 0.5 * (tangent[0] - tangent[1]);
  turn -= turn.dot(along) * along;
  const double sine = turn.norm();
  const double lean = (0.5 * (tangent[0] + tangent[1]) - along).norm();
  const double trusted = std::clamp(2.0 - 2.0 * lean / std::max(sine, 1e-300), 0.0, 1.0);
  const double cosine = std::sqrt(std::max(0.0, 1.0 - sine * sine));
  return 0.5 * length * trusted / (1.0 + cosine) * turn;
}

/// Makes the triangle's edges straight; returns whether one was not straight before.
bool Patches::Straighten(std::uint32_t t) {
  bool changed = false;
  for (const std::uint32_t e : edge_of_[t]) {
    changed |= !rise_[e].isZero(0.0);
    rise_[e].setZero();
  }
  return changed;
}

/// Returns whether the patch's normal differs too much from the triangle's, at a corner or
/// in the middle.
bool Patches::Folds(std::uint32_t t) const {
  const auto& [i, j, k] = mesh_.triangles[t];
  const Vec3 &ab = rise_[edge_of_[t][0]], &bc = rise_[edge_of_[t][1]], &ca = rise_[edge_of_[t][2]];
  if (ab.isZero(0.0) && bc.isZero(0.0) && ca.isZero(0.0)) return false;
  const Vec3 u = At(j) - At(i), v = At(k) - At(j), w = At(i) - At(k);
  const auto folds = [&](const Vec3& x, const Vec3& y) {
    const Vec3 n = x.cross(y);
    return n.dot(face_[t]) < kFoldCosine * n.norm();
  };
  return folds(u + 4.0 * ab, 4.0 * ca - w) || folds(v + 4.0 * bc, 4.0 * ab - u) ||
         folds(w + 4.0 * ca, 4.0 * bc - v) ||
         folds(u + 4.0 / 3.0 * (bc - ca), 4.0 / 3.0 * (bc - ab) - w);
}

/// Returns the control points of the patch, whose convex hull contains it.
std::array<Vec3, 6> Patches::Hull(std::uint32_t t) const {
  const auto& [i, j, k] = mesh_.triangles[t];
  const auto& e = edge_of_[t];
  return {At(i),
          At(j),
          At(k),
          0.5 * (At(i) + At(j)) + 2.0 * rise_[e[0]],
          0.5 * (At(j) + At(k)) + 2.0 * rise_[e[1]],
          0.5 * (At(k) + At(i)) + 2.0 * rise_[e[2]]};
}

bool ApartAlong(const std::array<Vec3, 6>& a, const std::array<Vec3, 6>& b, const Vec3& axis) {
  double a_min = axis.dot(a[0]), a_max = a_min, b_min = axis.dot(b[0]), b_max = b_min;
  for (std::size_t i = 1; i < 6; ++i) {
    a_min = std::min(a_min, axis.dot(a[i]));
    a_max = std::max(a_max, axis.dot(a[i]));
    b_min = std::min(b_min, axis.dot(b[i]));
    b_max = std::max(b_max, axis.dot(b[i]));
  }
  return a_max < b_min || b_max < a_min;
}

/// Keeps patches from meeting.  Two patches without a common corner both become flat if no plane
/// along an axis of their triangles separates their hulls; two with a common corner, if they are
/// the faces of a notch.  Finds pairs by sweeping boxes along x.
bool Patches::StraightenWherePatchesMeet() {
  const auto& triangles = mesh_.triangles;
  struct Box {
    Vec3 min, max;
    std::uint32_t triangle;
    bool curved;
  };
  std::vector<Box> boxes;
  bool any = false;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const auto hull = Hull(t);
    Box box{hull[0], hull[0], t, false};
    for (const Vec3& p : hull) {
      box.min = box.min.cwiseMin(p);
      box.max = box.max.cwiseMax(p);
    }
    for (const std::uint32_t e : edge_of_[t]) box.curved |= !rise_[e].isZero(0.0);
    any |= box.curved;
    boxes.push_back(box);
  }
  if (!any) return false;
  std::sort(boxes.begin(), boxes.end(), [](const Box& a, const Box& b) {
    return a.min.x() != b.min.x() ? a.min.x() < b.min.x() : a.triangle < b.triangle;
  });
  const auto share_a_corner = [&](std::uint32_t s, std::uint32_t t) {
    for (const std::uint32_t a : triangles[s]) {
      for (const std::uint32_t b : triangles[t]) {
        if (place_of_[a] == place_of_[b]) return true;
      }
    }
    return false;
  };
  const auto edge_along = [&](std::uint32_t t, std::size_t c) {
    return Vec3(At(triangles[t][(c + 1) % 3]) - At(triangles[t][c]));
  };
  const auto apart = [&](std::uint32_t s, std::uint32_t t) {
    const auto a = Hull(s), b = Hull(t);
    if (ApartAlong(a, b, face_[s]) || ApartAlong(a, b, face_[t])) return true;
    for (std::size_t i = 0; i < 3; ++i) {
      if (ApartAlong(a, b, face_[s].cross(edge_along(s, i))) ||
          ApartAlong(a, b, face_[t].cross(edge_along(t, i)))) {
        return true;
      }
      for (std::size_t k = 0; k < 3; ++k) {
        if (ApartAlong(a, b, edge_along(s, i).cross(edge_along(t, k)))) return true;
      }
    }
    return false;
  };
  const auto looks_at = [&](std::uint32_t s, std::uint32_t t) {
    return std::any_of(triangles[t].begin(), triangles[t].end(), [&](std::uint32_t v) {
      return face_[s].dot(At(v) - At(triangles[s][0])) > 0.0;
    });
  };
  const auto faces_in_a_notch = [&](std::uint32_t s, std::uint32_t t) {
    return face_[s].dot(face_[t]) < kNotchCosine && (looks_at(s, t) || looks_at(t, s));
  };
  bool changed = false;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Box& a = boxes[i];
    for (std::size_t k = i + 1; k < boxes.size() && boxes[k].min.x() <= a.max.x(); ++k) {
      const Box& b = boxes[k];
      if (!(a.curved || b.curved)) continue;
      if (b.min.y() > a.max.y() || a.min.y() > b.max.y()) continue;
      if (b.min.z() > a.max.z() || a.min.z() > b.max.z()) continue;
      const bool may_meet = share_a_corner(a.triangle, b.triangle)
                                ? faces_in_a_notch(a.triangle, b.triangle)
                                : !apart(a.triangle, b.triangle);
      if (!may_meet) continue;
      changed |= Straighten(a.triangle);
      changed |= Straighten(b.triangle);
    }
  }
  return changed;
}

/// Divides patches into triangles.
class Divider {
 public:
  Divider(const TriangleMesh& mesh, const Patches& patches, double tolerance, std::size_t most)
      : from_(mesh),
        patches_(patches),
        // A triangle of a patch deviates from it by at most 4 sum(u_i u_j rise_ij), u being the
        // place in the triangle; and the sum of the u_i u_j is at most 1/3.
        limit_(0.75 * tolerance),
        most_(most),
        points_(patches.edges()) {
    to_.mesh.vertices = mesh.vertices;
    to_.tolerance = tolerance;
  }

  /// Returns nothing if the triangles do not suffice.
  std::optional<CurvedMesh> Divide() {
    for (std::uint32_t t = 0; t < from_.triangles.size(); ++t) {
      parent_ = t;
      std::array<Indices, 3> sides;
      place_ = {};
      Lay();
      for (std::size_t c = 0; c < 3; ++c) sides[c] = SideOf(t, c);
      Fill(sides, 0);
      if (Full()) return std::nullopt;
    }
    return std::move(to_);
  }

 private:
  /// The place of a vertex in the parent, in barycentric coordinates.
  using Place = Vec3;

  /// Returns whether the limit is exceeded, and the result will be discarded.  One patch may be
  /// divided into 4096 x 4096 triangles, so this is asked before as well as after a division.
  bool Full(std::size_t more = 0) const { return to_.mesh.triangles.size() + more > most_; }

  std::size_t Segments(double rise) const {
    if (!(rise > limit_)) return 1;
    return static_cast<std::size_t>(std::min(std::ceil(std::sqrt(rise / limit_)), 4096.0));
  }

  /// Returns the points of a parent's edge, the same ones for both of its triangles.
  Indices SideOf(std::uint32_t t, std::size_t c) {
    const auto& corners = from_.triangles[t];
    const std::uint32_t e = patches_.edge(t, c);
    const bool forward = patches_.Forward(t, c);
    const std::uint32_t a = corners[c], b = corners[(c + 1) % 3];
    const std::size_t count = Segments(patches_.rise(e).norm());
    if (points_[e].empty() && count > 1) {
      const Vec3 &from = from_.vertices[forward ? a : b], &to = from_.vertices[forward ? b : a];
      for (std::size_t i = 1; i < count; ++i) {
        const double s = static_cast<double>(i) / static_cast<double>(count);
        points_[e].push_back(
            Add((1.0 - s) * from + s * to + 4.0 * s * (1.0 - s) * patches_.rise(e)));
      }
    }
    Indices side{a};
    if (forward) {
      side.insert(side.end(), points_[e].begin(), points_[e].end());
    } else {
      side.insert(side.end(), points_[e].rbegin(), points_[e].rend());
    }
    side.push_back(b);
    for (std::size_t i = 0; i < side.size(); ++i) {
      const double s = static_cast<double>(i) / static_cast<double>(count);
      Place place = Place::Zero();
      place[static_cast<int>(c)] = 1.0 - s;
      place[static_cast<int>((c + 1) % 3)] = s;
      if (i + 1 < side.size()) place_[side[i]] = place;
    }
    return side;
  }

  std::uint32_t Add(const Vec3& point) {
    to_.mesh.vertices.push_back(point);
    return static_cast<std::uint32_t>(to_.mesh.vertices.size() - 1);
  }

  const Place& PlaceOf(std::uint32_t vertex) const { return place_.at(vertex); }

  const Vec3& RiseOf(std::size_t c) const { return patches_.rise(patches_.edge(parent_, c)); }

  /// Returns the patch's quadratic part at a place, or along the difference of two places.
  Vec3 Quadratic(const Vec3& u) const {
    return u[0] * u[1] * RiseOf(0) + u[1] * u[2] * RiseOf(1) + u[2] * u[0] * RiseOf(2);
  }

  std::uint32_t AddInside(const Place& place) {
    const auto& [a, b, c] = from_.triangles[parent_];
    const auto& v = from_.vertices;
    const std::uint32_t made =
        Add(place[0] * v[a] + place[1] * v[b] + place[2] * v[c] + 4.0 * Quadratic(place));
    place_[made] = place;
    return made;
  }

  /// Returns a bound of the distance from the patch of the middle of a straight way through it.
  /// The way rises by -Q(way), Q being the quadratic form: the second difference of the patch
  /// along the way.  The part of the rise in the triangle's plane (all of it, in a cylinder's
  /// lid) moves the middle to another place of the patch, and away from it only in proportion to
  /// the patch's slope.
  double RiseAlong(const Vec3& way) const {
    const Vec3 rise = Quadratic(way);
    const double up = rise.dot(normal_);
    return std::abs(up) + steep_ * (rise - up * normal_).norm();
  }

  /// Computes the normal of the parent's plane, and the largest slope of its patch against it.
  void Lay() {
    normal_.setZero();
    steep_ = 0.0;
    std::array<Vec3, 3> along;
    for (std::size_t c = 0; c < 3; ++c) {
      along[c] = from_.vertices[from_.triangles[parent_][(c + 1) % 3]] -
                 from_.vertices[from_.triangles[parent_][c]];
    }
    normal_ = UnitOrZero(along[0].cross(along[1]));
    for (std::size_t c = 0; c < 3; ++c) {  // at the corner where side c begins
      const std::size_t last = (c + 2) % 3;
      const Vec3 n = (along[c] + 4.0 * RiseOf(c)).cross(along[last] - 4.0 * RiseOf(last));
      const double up = std::abs(n.dot(normal_));
      if (up > 0.0) steep_ = std::max(steep_, (n - n.dot(normal_) * normal_).norm() / up);
    }
  }

  /// Makes a new side between two vertices of the patch.
  Indices Between(std::uint32_t a, std::uint32_t b, int depth) {
    const Place from = PlaceOf(a), to = PlaceOf(b);
    const std::size_t count = depth < kDeepest ? Segments(RiseAlong(to - from)) : 1;
    Indices side{a};
    for (std::size_t i = 1; i < count; ++i) {
      const double s = static_cast<double>(i) / static_cast<double>(count);
      side.push_back(AddInside((1.0 - s) * from + s * to));
    }
    side.push_back(b);
    return side;
  }

  void Emit(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    to_.mesh.triangles.push_back({a, b, c});
    to_.source.push_back(parent_);
  }

  static Indices First(const Indices& side) {
    return {side.begin(), side.begin() + static_cast<std::ptrdiff_t>(side.size() / 2) + 1};
  }
  static Indices Second(const Indices& side) {
    return {side.begin() + static_cast<std::ptrdiff_t>(side.size() / 2), side.end()};
  }
  static std::uint32_t Middle(const Indices& side) { return side[side.size() / 2]; }
  static Indices Back(const Indices& side) { return {side.rbegin(), side.rend()}; }

  /// Fills a triangle of the patch between sides that are already divided.
  /// @param side  in turn, each from corner to corner.
  void Fill(std::array<Indices, 3> side, int depth) {
    if (Full()) return;
    const std::array<bool, 3> split{side[0].size() > 2, side[1].size() > 2, side[2].size() > 2};
    const int splits = int(split[0]) + int(split[1]) + int(split[2]);
    if (splits == 0) return Emit(side[0][0], side[1][0], side[2][0]);
    if (side[0].size() == side[1].size() && side[1].size() == side[2].size()) return Grid(side);
    if (splits == 3) {
      const std::array<std::uint32_t, 3> middle{Middle(side[0]), Middle(side[1]), Middle(side[2])};
      std::array<Indices, 3> inner;
      for (std::size_t c = 0; c < 3; ++c) {
        inner[c] = Between(middle[c], middle[(c + 1) % 3], depth);
      }
      for (std::size_t c = 0; c < 3; ++c) {  // at the corner where side c begins
        Fill({First(side[c]), Back(inner[(c + 2) % 3]), Second(side[(c + 2) % 3])}, depth + 1);
      }
      return Fill(inner, depth + 1);
    }
    if (splits == 1) {
      while (side[0].size() == 2) std::rotate(side.begin(), side.begin() + 1, side.end());
      const Indices across = Between(Middle(side[0]), side[2][0], depth);
      Fill({First(side[0]), across, side[2]}, depth + 1);
      return Fill({Second(side[0]), side[1], Back(across)}, depth + 1);
    }
    // Sides 0 and 2 are split: make a triangle at their common corner, and a quadrilateral.
    while (side[1].size() > 2) std::rotate(side.begin(), side.begin() + 1, side.end());
    const std::uint32_t m = Middle(side[0]), n = Middle(side[2]);
    const Indices cut = Between(m, n, depth);
    Fill({First(side[0]), cut, Second(side[2])}, depth + 1);
    const auto& v = to_.mesh.vertices;
    if ((v[m] - v[side[2][0]]).squaredNorm() <= (v[n] - v[side[1][0]]).squaredNorm()) {
      const Indices diagonal = Between(m, side[2][0], depth);
      Fill({Second(side[0]), side[1], Back(diagonal)}, depth + 1);
      Fill({diagonal, First(side[2]), Back(cut)}, depth + 1);
    } else {
      const Indices diagonal = Between(n, side[1][0], depth);
      Fill({Back(cut), Second(side[0]), Back(diagonal)}, depth + 1);
      Fill({diagonal, side[1], First(side[2])}, depth + 1);
    }
  }

  /// Fills a triangle whose sides all have n segments with n rows of the patch's own grid, whose
  /// segments rise as those of the sides.
  void Grid(const std::array<Indices, 3>& side) {
    const std::size_t n = side[0].size() - 1;
    if (Full(n * n)) {
      to_.mesh.triangles.resize(most_ + 1);
      return;
    }
    const std::array<Place, 3> corner{PlaceOf(side[0][0]), PlaceOf(side[1][0]),
                                      PlaceOf(side[2][0])};
    Indices above{side[0][0]};
    for (std::size_t row = 1; row <= n; ++row) {  // away from corner 0
      Indices here{side[0][row]};
      for (std::size_t k = 1; k < row; ++k) {
        if (row == n) {
          here.push_back(side[1][k]);
          continue;
        }
        const double x = static_cast<double>(row - k) / static_cast<double>(n);
        const double y = static_cast<double>(k) / static_cast<double>(n);
        here.push_back(AddInside((1.0 - x - y) * corner[0] + x * corner[1] + y * corner[2]));
      }
      here.push_back(side[2][n - row]);
      for (std::size_t k = 0; k < row; ++k) {
        Emit(above[k], here[k], here[k + 1]);
        if (k + 1 < row) Emit(above[k], here[k + 1], above[k + 1]);
      }
      above = std::move(here);
    }
  }

  const TriangleMesh& from_;
  const Patches& patches_;
  double limit_;  ///< of a side's rise [m]
  std::size_t most_;
  std::vector<Indices> points_;  ///< of each parent's edge, between its ends
  std::uint32_t parent_ = 0;
  Vec3 normal_ = Vec3::Zero();                      ///< of the parent
  double steep_ = 0.0;                              ///< largest slope of its patch against it
  std::unordered_map<std::uint32_t, Place> place_;  ///< of the vertices of the parent's patch
  CurvedMesh to_;
};

}  // namespace

CurvedMesh RefineCurved(const TriangleMesh& mesh, const CurvedOptions& options) {
  const Patches patches(mesh);
  const std::size_t most = std::max(options.max_triangles, mesh.triangles.size());
  for (double tolerance = options.tolerance;; tolerance *= 2.0) {
    if (auto refined = Divider(mesh, patches, tolerance, most).Divide()) return *std::move(refined);
  }
}

}  // namespace palpate
