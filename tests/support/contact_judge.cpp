#include "tests/support/contact_judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "tests/support/cone_projection.h"
#include "tests/support/triangle_tree.h"

namespace palpate::test {
namespace {

using Real = long double;
using V = Eigen::Matrix<Real, 3, 1>;
using M = Eigen::Matrix<Real, 3, 3>;
using Box = TriangleTree::Box;
using Node = TriangleTree::Node;

constexpr Real kLean = ContactJudge::kLean, kSame = ContactJudge::kSame;
/// Nearer than this, points give no direction [m]: meshes that touch or meet are not at rest.
constexpr Real kNoDirection = 1e-9L;
/// Farther than this from the nearest points' direction, sine and cosine of 60 degrees, no other
/// counts: the far side of a thin sheet is nobody's contact.
constexpr Real kWidestSine = 0.866025403784438647L, kWidestCosine = 0.5L;
/// Edges of the pyramid round a cone of friction: its corners stand out by 0.5 %.
constexpr int kPyramid = 32;
/// The normal of a triangle is known to some roundings of its corners (2^-53 each) over its height.
/// A sliver that knows its own to no better than a tenth of kLean counts as a line.
constexpr Real kCornerRounding = 4.5e-16L;

V Unit(const V& v) {
  const Real length = v.norm();
  return length > 0 ? V(v / length) : V(V::Zero());
}

/// X_BT in long doubles, from poses whose quaternions deviate from unit length by rounding.
struct Motion {
  Motion() = default;
  Motion(const Pose& X_WB, const Pose& X_WT) {
    const M R_BW = X_WB.q.cast<Real>().normalized().toRotationMatrix().transpose();
    R = R_BW * X_WT.q.cast<Real>().normalized().toRotationMatrix();
    p = R_BW * (X_WT.p.cast<Real>() - X_WB.p.cast<Real>());
  }
  V operator*(const V& at) const { return R * at + p; }
  Box operator*(const Box& box) const {
    const Vec3 center = (R * box.center.cast<Real>() + p).cast<double>();
    const Vec3 half = R.cast<double>().cwiseAbs() * box.half;
    return {center, half + Vec3::Constant(1e-15 * (center.cwiseAbs().sum() + half.sum()))};
  }
  M R = M::Identity();
  V p = V::Zero();
};

/// The directions along a triangle from one of its points: a plane, a half-plane along an edge, or
/// the wedge at a corner.  Without a normal: a line, or rays.
struct Tangent {
  V normal = V::Zero();
  enum { kPlane, kHalf, kWedge } shape = kPlane;
  V a = V::Zero(), b = V::Zero();  ///< kHalf: along the edge, inward; kWedge: along its two edges

  /// The sine by which the triangle rises towards n (unit) at most.
  Real Rise(const V& n) const {
    if (normal.isZero()) return shape == kWedge ? std::max(a.dot(n), b.dot(n)) : std::abs(a.dot(n));
    const V along = n - normal.dot(n) * normal;
    if (shape == kPlane) return along.norm();
    if (shape == kHalf) return b.dot(n) > 0 ? along.norm() : std::abs(a.dot(n));
    const bool within = normal.dot(a.cross(along)) >= 0 && normal.dot(along.cross(b)) >= 0;
    return within ? along.norm() : std::max(a.dot(n), b.dot(n));
  }
};

struct Feature {
  enum Kind : std::uint32_t { kCorner, kEdge, kFace } kind;
  std::uint32_t a, b;  ///< a corner's number; an edge's two; a triangle's number
  auto operator<=>(const Feature&) const = default;
};

V NearestOnLine(const V& a, const V& b, const V& to) {
  const Real length2 = (b - a).squaredNorm();
  if (length2 == 0) return a;
  return a + std::clamp<Real>((to - a).dot(b - a) / length2, 0, 1) * (b - a);
}

/// The nearest points of two features where each is inside of its feature; else they are those of
/// features at its rim.  But a corner over a face, and two edges that cross, also count up to
/// kPlace beyond the rim: a corner at rest in a valley is over one side of it alone if its pose is
/// off by a fraction of the separation.  `at_rim`: which of the two points is as near to its
/// feature's rim, on either side.
struct Closest {
  V on_a, on_b;
  bool a_at_rim = false, b_at_rim = false;

  Closest Swapped() const { return {on_b, on_a, b_at_rim, a_at_rim}; }
};
using MaybeClosest = std::optional<Closest>;

MaybeClosest CornerToEdge(const V& c, const V& a, const V& b) {
  const V along = b - a;
  const Real part = (c - a).dot(along) / along.squaredNorm();
  if (!(part >= 0 && part <= 1)) return {};
  return Closest{c, a + part * along};
}

MaybeClosest CornerToFace(const V& c, const std::array<V, 3>& t) {
  const V across = (t[1] - t[0]).cross(t[2] - t[0]);
  const V foot = c - (c - t[0]).dot(across) / across.squaredNorm() * across;
  bool inside = true;
  Real to_rim = std::numeric_limits<Real>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const V &from = t[i], &to = t[(i + 1) % 3];
    inside = inside && across.dot((to - from).cross(foot - from)) >= 0;
    to_rim = std::min(to_rim, (NearestOnLine(from, to, foot) - foot).norm());
  }
  const bool at_rim = to_rim <= ContactJudge::kPlace;
  if (!inside && !at_rim) return {};
  return Closest{c, foot, false, at_rim};
}

MaybeClosest EdgeToEdge(const V& a, const V& b, const V& c, const V& d) {
  const V u = b - a, w = d - c, from = c - a;
  const V across = u.cross(w);
  const Real across2 = across.squaredNorm();
  const Real s = across.dot(from.cross(w)) / across2, t = across.dot(from.cross(u)) / across2;
  const auto beyond = [](Real part, const V& edge) {
    return std::max(-part, part - 1) * edge.norm();
  };
  const Real by_a = beyond(s, u), by_b = beyond(t, w);
  if (!(std::max(by_a, by_b) <= ContactJudge::kPlace)) return {};
  return Closest{a + s * u, c + t * w, by_a > -ContactJudge::kPlace, by_b > -ContactJudge::kPlace};
}

}  // namespace

/// A mesh whose corners at one place have one number.
struct ContactJudge::Part {
  Part(const TriangleMesh& mesh, const Object& placed)
      : tree(mesh), X_WB(placed.X_WB), static_friction(placed.static_friction) {
    std::map<std::array<double, 3>, std::uint32_t> numbers;
    for (const Vec3& v : mesh.vertices) {
      const std::array<double, 3> key{v.x() + 0.0, v.y() + 0.0, v.z() + 0.0};  // no -0
      const auto [at, is_new] = numbers.try_emplace(key, static_cast<std::uint32_t>(place.size()));
      if (is_new) place.push_back(v.cast<Real>());
      number.push_back(at->second);
    }
  }
  std::array<std::uint32_t, 3> Corners(std::uint32_t triangle) const {
    const auto& t = tree.corners(triangle);
    return {number[t[0]], number[t[1]], number[t[2]]};
  }
  std::array<V, 3> At(std::uint32_t triangle) const {
    const auto c = Corners(triangle);
    return {place[c[0]], place[c[1]], place[c[2]]};
  }
  /// The features of a triangle, its corners first; what has no extent is left out.
  void FeaturesOf(std::uint32_t triangle, std::vector<Feature>& features) const {
    features.clear();
    const auto c = Corners(triangle);
    for (std::size_t i = 0; i < 3; ++i) features.push_back({Feature::kCorner, c[i], 0});
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(c[i], c[(i + 1) % 3]);
      if (low != high) features.push_back({Feature::kEdge, low, high});
    }
    if (!NormalOf(At(triangle)).isZero()) features.push_back({Feature::kFace, triangle, 0});
  }
  V MiddleOf(const Feature& of) const {
    if (of.kind == Feature::kEdge) return (place[of.a] + place[of.b]) / 2;
    const auto [a, b, c] = At(of.a);
    return (a + b + c) / 3;
  }
  static V NormalOf(const std::array<V, 3>& t) {
    const V across = (t[1] - t[0]).cross(t[2] - t[0]);
    Real longest = 0, farthest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      longest = std::max(longest, (t[(i + 1) % 3] - t[i]).norm());
      farthest = std::max(farthest, t[i].cwiseAbs().maxCoeff());
    }
    const bool known = across.norm() * kLean > 10 * kCornerRounding * farthest * longest;
    return known ? V(across.normalized()) : V(V::Zero());
  }
  /// How the triangles lie that have the place p, in this part's frame.
  std::vector<Tangent> TangentsAt(const V& p) const;

  TriangleTree tree;
  Pose X_WB;
  std::function<double(const Vec3&)> static_friction;
  std::vector<V> place;
  std::vector<std::uint32_t> number;  ///< of each of the mesh's vertices
};

namespace {

std::optional<Tangent> TangentOf(const std::array<V, 3>& t, const V& normal, const V& p) {
  Tangent tangent{normal};
  std::array<Real, 3> corner, edge;
  for (std::size_t i = 0; i < 3; ++i) {
    corner[i] = (t[i] - p).norm();
    edge[i] = (NearestOnLine(t[i], t[(i + 1) % 3], p) - p).norm();
  }
  const auto nearest = [](const std::array<Real, 3>& d) {
    return static_cast<std::size_t>(std::min_element(d.begin(), d.end()) - d.begin());
  };
  const std::size_t c = nearest(corner), e = nearest(edge);
  if (corner[c] <= kSame) {
    tangent.shape = Tangent::kWedge;
    tangent.a = Unit(t[(c + 1) % 3] - t[c]);
    tangent.b = Unit(t[(c + 2) % 3] - t[c]);
    if (tangent.a.isZero() && tangent.b.isZero()) return {};
    return tangent;
  }
  if (edge[e] <= kSame) {
    tangent.shape = Tangent::kHalf;
    tangent.a = Unit(t[(e + 1) % 3] - t[e]);
    tangent.b = normal.cross(tangent.a);
    return tangent;
  }
  if (normal.isZero() || std::abs(normal.dot(p - t[0])) > kSame) return {};
  for (std::size_t i = 0; i < 3; ++i) {
    if (normal.dot((t[(i + 1) % 3] - t[i]).cross(p - t[i])) < 0) return {};
  }
  return tangent;
}

/// Visits the pairs of triangles that are nearer than `within`, and some more.
template <class Visit>
void VisitNear(const TriangleTree& tool, const TriangleTree& object, const Motion& X_BT,
               const Motion& X_TB, double within, const Visit& visit) {
  const auto step = [&](const auto& self, const Node& a, const Node& b) -> void {
    if ((X_BT * a.box).Distance(b.box) > within || (X_TB * b.box).Distance(a.box) > within) return;
    if (a.leaf() && b.leaf()) {
      for (const std::uint32_t i : tool.TrianglesOf(a)) {
        const Triangle t = tool.At(i);
        const Box box = X_BT * TriangleTree::BoxOf(t);
        for (const std::uint32_t k : object.TrianglesOf(b)) {
          if (box.Distance(TriangleTree::BoxOf(object.At(k))) <= within) visit(i, k);
        }
      }
    } else if (b.leaf() || (!a.leaf() && a.box.half.sum() > b.box.half.sum())) {
      self(self, tool.first(a), b);
      self(self, tool.second(a), b);
    } else {
      self(self, a, object.first(b));
      self(self, a, object.second(b));
    }
  };
  if (!tool.empty() && !object.empty()) step(step, tool.root(), object.root());
}

/// The normal cones of two features, in the object's frame.
struct Cones {
  std::vector<Tangent> object, tool;

  /// The sine by which n, from the object to the tool, lies outside of them.
  Real Outside(const V& n) const {
    Real sine = 0;
    for (const Tangent& t : object) sine = std::max(sine, t.Rise(n));
    for (const Tangent& t : tool) sine = std::max(sine, t.Rise(-n));
    return sine;
  }
  /// The directions at which their intersection can have a corner.
  std::vector<V> Corners() const {
    std::vector<V> corners, lines;
    const auto add = [](std::vector<V>& all, const V& v) {
      const bool known = v.isZero() || std::ranges::any_of(all, [&](const V& other) {
                           return v.cross(other).squaredNorm() < 1e-16L;
                         });
      if (!known) all.push_back(v);
    };
    for (const std::vector<Tangent>* side : {&object, &tool}) {
      for (const Tangent& t : *side) {
        add(corners, t.normal);
        add(lines, t.a);
        if (t.shape == Tangent::kWedge) add(lines, t.b);
      }
    }
    for (std::size_t i = 0; i < lines.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) corners.push_back(Unit(lines[i].cross(lines[k])));
    }
    return corners;
  }
};

/// The outermost directions of contact of two features whose nearest points have the direction n.
/// @param sine  of the angle by which a pose that is off by kPlace may turn it.
std::vector<V> DirectionsOf(const Cones& cones, const V& n, Real sine) {
  struct Candidate {
    V direction;
    Real outside;
  };
  std::vector<Candidate> candidates;
  const auto add = [&](const V& direction) {
    candidates.push_back({direction, cones.Outside(direction)});
    return candidates.back().outside <= kLean;
  };
  const bool holds = add(n);
  sine = std::min(sine, kWidestSine);
  const Real cosine = std::max(kWidestCosine, std::sqrt(1 - sine * sine));
  for (V corner : cones.Corners()) {
    if (corner.dot(n) < 0) corner = -corner;
    if (corner.dot(n) >= cosine) {
      add(corner);
    } else if (holds && cones.Outside(corner) <= kLean) {
      add(cosine * n + sine * Unit(corner - corner.dot(n) * n));  // on the way there from n
    }
  }
  // Of directions that differ by no more than the tolerance only the best counts: no contact of a
  // plane has another normal than the plane's.
  std::ranges::sort(candidates, {}, &Candidate::outside);
  std::vector<V> directions;
  for (const Candidate& c : candidates) {
    const auto is_near = [&](const V& other) { return (other - c.direction).norm() < 2 * kLean; };
    if (c.outside > kLean || std::ranges::any_of(directions, is_near)) continue;
    directions.push_back(c.direction);
  }
  return directions;
}

std::function<double(const Vec3&)> FrictionOf(const Body& body) {
  const auto of = [&body](std::size_t leaf) {
    return body.materials[body.leaf_material.empty() ? 0 : body.leaf_material[leaf]]
        .static_friction;
  };
  return [&body, of](const Vec3& p) {
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < body.tree.leaves() && !body.leaf_material.empty(); ++i) {
      const Vec3 center(body.tree.leaf_x[i], body.tree.leaf_y[i], body.tree.leaf_z[i]);
      const double distance = (p - center).norm() - body.tree.leaf_radius[i];
      if (distance >= least) continue;
      least = distance;
      nearest = i;
    }
    return of(nearest);
  };
}

ContactJudge::Tool ToolOf(const Scene& scene, const Vec3& reference) {
  const Body& tool = scene.tools.front();
  ContactJudge::Tool judged{.mesh = &tool.mesh, .reference = reference};
  if (tool.tree.leaves() == 1) {
    judged.center = {tool.tree.leaf_x[0], tool.tree.leaf_y[0], tool.tree.leaf_z[0]};
    judged.radius = tool.tree.leaf_radius[0];
  }
  return judged;
}

std::vector<ContactJudge::Object> ObjectsOf(const Scene& scene) {
  std::vector<ContactJudge::Object> objects;
  for (const Body& body : scene.objects) {
    objects.push_back({&body.mesh, body.X_WB});
    if (scene.features.friction != FrictionModel::kOff) {
      objects.back().static_friction = FrictionOf(body);
    }
  }
  return objects;
}

}  // namespace

std::vector<Tangent> ContactJudge::Part::TangentsAt(const V& p) const {
  std::vector<Tangent> tangents;
  const Box at{p.cast<double>(), Vec3::Zero()};
  const auto visit = [&](const auto& self, const Node& node) -> void {
    if (node.box.Distance(at) > 2.0 * kSame) return;
    if (!node.leaf()) {
      self(self, tree.first(node));
      self(self, tree.second(node));
      return;
    }
    for (const std::uint32_t i : tree.TrianglesOf(node)) {
      const auto t = At(i);
      if (const auto tangent = TangentOf(t, NormalOf(t), p)) tangents.push_back(*tangent);
    }
  };
  visit(visit, tree.root());
  return tangents;
}

ContactJudge::ContactJudge(const Tool& tool, const std::vector<Object>& objects)
    : radius_(tool.radius), reference_(tool.reference) {
  // A ball is a corner without neighbours, and its radius.
  const TriangleMesh point{{tool.center}, {{0, 0, 0}}};
  tool_ = std::make_unique<const Part>(radius_ > 0.0 ? point : *tool.mesh, Object{});
  for (const Object& object : objects) objects_.emplace_back(*object.mesh, object);
}

ContactJudge::ContactJudge(const Scene& scene, const Vec3& reference)
    : ContactJudge(ToolOf(scene, reference), ObjectsOf(scene)) {}

ContactJudge::~ContactJudge() = default;

std::string ContactJudge::WhyNot(const Scene& scene) {
  if (scene.features.contact != ContactModel::kSurface) return "contact is between leaves";
  if (!scene.moved.empty()) return "objects move";
  if (scene.features.friction == FrictionModel::kChapter) return "friction is the chapter's";
  for (const Body& object : scene.objects) {
    if (object.grid) return "a bur can cut " + object.name;
  }
  return {};
}

/// Two features that are near, and their nearest points, in the object's frame: a is the tool's.
struct ContactJudge::NearPair {
  Feature of_tool, of_object;
  Closest points;
};

/// The nearest points of a feature of `a`, moved by X, and of one of `b`.
template <class Part>
MaybeClosest NearestPoints(const Part& part_a, const Motion& X, const Feature& a,
                           const Part& part_b, const Feature& b) {
  const auto swapped = [](const MaybeClosest& nearest) -> MaybeClosest {
    if (!nearest) return {};
    return nearest->Swapped();
  };
  const auto moved = [&](std::uint32_t corner) { return V(X * part_a.place[corner]); };
  const auto still = [&](std::uint32_t corner) { return part_b.place[corner]; };
  if (a.kind == Feature::kFace) {
    const auto [p, q, r] = part_a.Corners(a.a);
    return swapped(CornerToFace(still(b.a), {moved(p), moved(q), moved(r)}));
  }
  if (b.kind == Feature::kFace) return CornerToFace(moved(a.a), part_b.At(b.a));
  if (a.kind == Feature::kEdge && b.kind == Feature::kEdge) {
    return EdgeToEdge(moved(a.a), moved(a.b), still(b.a), still(b.b));
  }
  if (a.kind == Feature::kEdge) return swapped(CornerToEdge(still(b.a), moved(a.a), moved(a.b)));
  if (b.kind == Feature::kEdge) return CornerToEdge(moved(a.a), still(b.a), still(b.b));
  return Closest{moved(a.a), still(b.a)};
}

std::vector<ContactJudge::NearPair> ContactJudge::NearPairs(const Part& object,
                                                            const Pose& X_WT) const {
  const Motion X_BT(object.X_WB, X_WT), X_TB(X_WT, object.X_WB);
  const double reach = radius_ + kNear;
  std::vector<NearPair> pairs;
  std::vector<Feature> of_tool, of_object;
  VisitNear(tool_->tree, object.tree, X_BT, X_TB, reach + 2 * kPlace,
            [&](std::uint32_t i, std::uint32_t k) {
              tool_->FeaturesOf(i, of_tool);
              object.FeaturesOf(k, of_object);
              for (const Feature& a : of_tool) {
                for (const Feature& b : of_object) {
                  // An edge and a face, and two faces, are nearest at a corner, or at edges of
                  // both.
                  if (a.kind + b.kind > Feature::kFace) continue;
                  const MaybeClosest points = NearestPoints(*tool_, X_BT, a, object, b);
                  if (points && (points->on_a - points->on_b).norm() <= reach) {
                    pairs.push_back({a, b, *points});
                  }
                }
              }
            });
  const auto features = [](const NearPair& p) { return std::pair(p.of_tool, p.of_object); };
  std::ranges::sort(pairs, {}, features);
  pairs.erase(std::ranges::unique(pairs, {}, features).begin(), pairs.end());
  return pairs;
}

std::vector<ContactJudge::Contact> ContactJudge::ContactsAt(const Pose& X_WT) const {
  std::vector<Contact> contacts;
  for (const Part& object : objects_) {
    const Motion X_BT(object.X_WB, X_WT), X_TB(X_WT, object.X_WB), X_WB(Pose{}, object.X_WB);
    for (const auto& [of_tool, of_object, points] : NearPairs(object, X_WT)) {
      const auto& [on_tool, on_object, tool_at_rim, object_at_rim] = points;
      const V from = on_tool - on_object;
      const Real apart = from.norm();
      if (apart < kNoDirection) continue;
      // At its rim a feature has the cone that it has in its middle.
      Cones cones{object.TangentsAt(object_at_rim ? object.MiddleOf(of_object) : on_object),
                  tool_->TangentsAt(tool_at_rim ? tool_->MiddleOf(of_tool) : V(X_TB * on_tool))};
      for (Tangent& t : cones.tool) {
        for (V* v : {&t.normal, &t.a, &t.b}) *v = X_BT.R * *v;
      }
      const V n = from / apart, at = on_tool - static_cast<Real>(radius_) * n;
      const double mu =
          object.static_friction ? object.static_friction(on_object.cast<double>()) : 0.0;
      for (const V& direction : DirectionsOf(cones, n, kPlace / apart)) {
        contacts.push_back({(X_WB * at).cast<double>(), (X_WB.R * direction).cast<double>(),
                            static_cast<double>(apart) - radius_, mu});
      }
    }
  }
  return contacts;
}

ContactJudge::Verdict ContactJudge::Judge(const Pose& X_WT, const Wrench& pull,
                                          double length) const {
  const V reference = Motion(Pose{}, X_WT) * reference_.cast<Real>();
  std::vector<Vec6L> generators;
  const std::vector<Contact> contacts = ContactsAt(X_WT);
  for (const Contact& contact : contacts) {
    const V lever = contact.at_W.cast<Real>() - reference, n = contact.normal_W.cast<Real>();
    const auto add = [&](const V& force) {
      // The contacts' forces oppose the pull.  Nothing turns a ball.
      Vec6L wrench = Vec6L::Zero();
      wrench.head<3>() = -force;
      if (!(radius_ > 0.0)) wrench.tail<3>() = -lever.cross(force) / length;
      generators.push_back(wrench.normalized());
    };
    if (!(contact.static_friction > 0.0)) {
      add(n);
      continue;
    }
    const V t = n.unitOrthogonal(), u = n.cross(t);
    const Real step = 2 * std::numbers::pi_v<Real> / kPyramid;
    const Real mu = contact.static_friction / std::cos(step / 2);
    for (int i = 0; i < kPyramid; ++i) {
      add(n + mu * (std::cos(i * step) * t + std::sin(i * step) * u));
    }
  }
  Vec6L pulled;
  pulled << pull.force.cast<Real>(), pull.torque.cast<Real>() / length;
  const Vec6L left = LeftOfCone(generators, pulled, kLean);
  return {static_cast<double>(left.head<3>().norm()),
          static_cast<double>(left.tail<3>().norm() * length), contacts.size()};
}

Wrench SpringPull(const Pose& X_WG, const Pose& X_WH, const Vec3& reference,
                  const Coupling& coupling, const Wrench& published) {
  const V at = reference.cast<Real>();
  const V apart = Motion(Pose{}, X_WH) * at - Motion(Pose{}, X_WG) * at;
  const Eigen::Quaternion<Real> q = X_WH.q.cast<Real>() * X_WG.q.cast<Real>().conjugate();
  // A turn and its complement the other way round; the step keeps the one that it came by.
  const V axis = q.vec().norm() > 0 ? V(q.vec().normalized()) : V(V::Zero());
  const Real angle = 2 * std::atan2(q.vec().norm(), q.w());
  const V told = -published.torque.cast<Real>() / coupling.torsional_stiffness;
  const V turn = angle * axis, other = (angle - 2 * std::numbers::pi_v<Real>)*axis;
  const V phi = (turn - told).norm() <= (other - told).norm() ? turn : other;
  return {(coupling.stiffness * apart).cast<double>(),
          (coupling.torsional_stiffness * phi).cast<double>()};
}

}  // namespace palpate::test
