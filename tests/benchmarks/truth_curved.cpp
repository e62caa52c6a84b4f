// Tools on meshes of curved bodies, against the smooth surface.  The hand is a depth d below the
// place where the tool would rest on the surface, along its normal n there: so the tool rests above
// it, and the force is k d n.  On the mesh it may differ by no more than the mesh does.  With e the
// greatest distance of mesh and surface, f the greatest angle between a triangle and the surface,
// K the curvature (K_max, K_min over all sections; below 0 where hollow):
//
// Ball of radius r.  Its contact q has a normal m within f of the surface's there, whether m is a
//   triangle's or one between those of the triangles around (both are the gradient's, linear over a
//   triangle, between their values at corners).  The force is along m, so with t = m - n the ball
//   is d t beside its place, its contact (r - d) t on the other side, where the surface's normal is
//   n - K (r - d) t.  What is left to m is at most f: |t| <= f / (1 + K (r - d)), with the K that
//   makes it greatest.  Size: the rest is no nearer than d - e, and no farther than the tangent
//   plane (of a hollow surface: than it curves up) along m, d / cos t + d^2 t^2 |K_min| / 2 + e.
//
// Foot on a convex body: a tool that is a plane with normal n, h below the centroid, turned by p.
//   The mesh lies in the body, so where the tool rests on the surface it is free of the mesh, and
//   the energy of its rest is at most k d^2 / 2: with v the shift, |v|^2 + (k_r/k) p^2 <= d^2.  The
//   mesh is at most e' = e + K_max x^2 / 2 below the tangent plane at a distance x beside it; the
//   middle of the foot is x <= d s + h p beside (s the angle of v to n), and above the mesh:
//   n . v >= d - e' - h p^2 / 2.  From these two
//     p^2 <= 2 d e' / (k_r/k - h d),   s^2 <= 2 e' / d   (while k_r/k > h d),
//     e' <= e / (1 - K_max d g^2),  g = 1 + h / sqrt(k_r/k - h d),   d - e' - h p^2/2 <= |v| <= d.
//   The torque is k_r p.
//
// Foot wider than a triangle: it touches corners and edges with its face alone, so the force is
//   along its normal, and s <= p.  What touches is at most e below the plane at the point of the
//   surface that has this normal, and so at most x = sqrt(2 e / K_min) beside that point.  The
//   point lies at least (1/K_max + h - d) p beside the centroid's normal, on the side on which the
//   load turns the tool back: k_r p <= k d (x - (1/K_max + h - d) p), so that
//     p <= d x / (k_r/k + d (1/K_max + h - d)).
//
// A tool with a mesh may be as near as half the separation at some points and not at others, which
// adds to e.
#include "tests/benchmarks/truth_curved.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "tests/benchmarks/truth_hands.h"
#include "tests/benchmarks/truth_judges.h"
#include "tests/support/sharp_bodies.h"
#include "tests/support/test_scenes.h"

namespace palpate::bench {
namespace {

using test::CurvedBody;
using test::Random;

constexpr std::string_view kTools[] = {"ball", "box", "pin"};
constexpr std::pair<std::string_view, std::size_t> kSizes[] = {
    {"1e3", 1'000}, {"1e4", 10'000}, {"1e5", 100'000}, {"1e6", 1'000'000}};

/// A tool that stands on y = const.
Body MakeTool(std::string_view tool, const CurvedBody& body, Random& random) {
  const double size = random.Uniform(0.004, 0.008), height = random.Uniform(0.006, 0.01);
  if (tool == "ball") return test::BallBody(0.5 * size);
  if (tool == "pin") {
    std::vector<Vec3> outline;
    for (int i = 0; i < 6; ++i) {
      const double angle = M_PI / 3.0 * i;
      outline.push_back(0.1 * size * Vec3(std::cos(angle), std::sin(angle), 0.0));
    }
    TriangleMesh pin = test::Extruded(outline, height);
    for (Vec3& v : pin.vertices) v = Vec3(v.y(), v.z(), v.x());
    return test::MakeSolidBody("pin", std::move(pin));
  }
  const double wide = std::max(size, 2.5 * body.longest_edge());
  return test::MakeSolidBody("box", MakeBox({wide, height, wide}));
}

/// The path of a hand: where it is above the surface, and how far it is turned.
struct CurvedPath {
  std::vector<CurvedBody::Point> on;
  std::vector<Quat> q;
};

/// Comes down at a point, then goes ahead, turning with the surface.
CurvedPath MakePath(const CurvedBody& body, bool convex, double speed, int steps, Random& random) {
  Vec3 along;
  CurvedBody::Point at = body.Start(convex, along, random);
  CurvedPath path;
  Quat q = RotationExp(random.Uniform(-M_PI, M_PI) * at.normal) *
           RotationBetween(Vec3::UnitY(), at.normal);
  for (int i = 0; i < steps; ++i) {
    path.on.push_back(at);
    path.q.push_back(q);
    if (i < kDown) continue;
    const CurvedBody::Point next = body.Nearest(at.at + 1e-3 * speed * along);
    const Quat turn = RotationBetween(at.normal, next.normal);
    along = turn * along;
    along = (along - along.dot(next.normal) * next.normal).normalized();
    q = (turn * q).normalized();
    at = next;
  }
  return path;
}

TruthHand MakeHand(std::string_view kind, std::size_t triangles, std::string_view tool,
                   std::uint64_t seed, bool rubs) {
  Random random(seed);
  const auto body = std::make_shared<const CurvedBody>(kind, triangles, random);
  Scene scene;
  scene.name = "truth";
  scene.tools.push_back(MakeTool(tool, *body, random));
  scene.objects.push_back(SurfaceBody(std::string(kind), body->mesh()));
  const Pose X_WB{random.InCube(0.2), random.Rotation()};
  scene.objects.front().X_WB = X_WB;
  const double depth = Decades(random, 5e-4, rubs ? 1.5e-3 : 3e-3),
               speed = Decades(random, rubs ? 5e-3 : 1e-3, 0.1);
  const double run_in = (kTruthStatic + 8.0 * kTruthDynamic) * depth + 3e-4;
  const auto steady = static_cast<std::size_t>(kDown + std::ceil(1e3 * run_in / speed));
  const int most = rubs ? static_cast<int>(steady) + 500 : kDown + 500;
  const double way = rubs ? run_in + 8e-3 : 0.015;
  const int steps = std::min(most, kDown + static_cast<int>(1e3 * way / speed));
  const Body& driven = scene.tools.front();
  const bool is_ball = tool == "ball";
  CurvedTool how{is_ball,
                 tool == "box",
                 0.0,
                 scene.coupling.stiffness,
                 scene.coupling.torsional_stiffness,
                 is_ball ? 0.0 : 0.5 * scene.tuning.separation};
  how.height = is_ball ? driven.tree.leaf_radius[0] : 0.0;
  for (const Vec3& v : driven.mesh.vertices) {
    if (!is_ball) how.height = std::max(how.height, driven.tree.centroid.y() - v.y());
  }
  const CurvedPath path = MakePath(*body, !is_ball, speed, steps, random);
  std::vector<Pose> X_WH;
  std::vector<CurvedJudge::Sample> samples;
  for (int i = 0; i < steps; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const CurvedBody::Point& on = path.on[at];
    const double below = DepthAt(i, depth), deep = below + scene.tuning.separation;
    const Quat q = is_ball ? Quat::Identity() : path.q[at];
    X_WH.push_back(X_WB *
                   Pose{on.at + (how.height - below) * on.normal - q * driven.tree.centroid, q});
    samples.push_back({X_WB.q * on.normal, deep, BoundOf(*body, how, deep)});
  }
  if (!rubs) {
    const double shallow = std::max(1e-4, 3.0 * body->sagitta());
    return JudgedBy(CurvedJudge(how, shallow, std::move(samples)), std::move(scene),
                    std::move(X_WH));
  }
  scene.features.friction = FrictionModel::kCoulomb;
  scene.objects.front().materials = {
      {.static_friction = kTruthStatic, .dynamic_friction = kTruthDynamic}};
  const double bound = is_ball ? body->facet_angle() : 0.0;
  return JudgedBy(CurvedSlideJudge(body, how, X_WB, bound, steady), std::move(scene),
                  std::move(X_WH));
}

}  // namespace

CurvedBound BoundOf(const CurvedBody& body, const CurvedTool& tool, double depth) {
  const double d = std::max(depth, 0.0), e = body.sagitta() + tool.slack, k = tool.stiffness;
  if (tool.is_ball) {
    const double lever = tool.height - d;
    const double bends = lever * (lever > 0.0 ? body.least_curvature() : body.greatest_curvature());
    const double t = body.facet_angle() / std::max(1e-3, 1.0 + bends);
    const double hollow = std::max(0.0, -body.least_curvature());
    return {t,
            k * (e + d * (1.0 / std::cos(std::min(t, 1.0)) - 1.0) + 0.5 * d * d * t * t * hollow),
            0.0};
  }
  const double h = tool.height, springs = tool.torsional / k - h * d;
  const double g = 1.0 + h / std::sqrt(springs);
  const double lower = e / (1.0 - body.greatest_curvature() * d * g * g);
  double turn = std::sqrt(2.0 * d * lower / springs);
  if (tool.is_wide && body.least_curvature() > 0.0) {
    const double beside = std::sqrt(2.0 * e / body.least_curvature());
    const double rolls = d * (1.0 / body.greatest_curvature() + h - d);
    turn = std::min(turn, d * beside / (tool.torsional / k + rolls));
  }
  const double angle = d > 0.0 ? std::sqrt(2.0 * lower / d) : INFINITY;
  return {tool.is_wide ? std::min(angle, turn) : angle, k * (lower + 0.5 * h * turn * turn), turn};
}

void CurvedJudge::See(std::size_t i, const StepReport& report) {
  const auto worse = [](double& worst, double value) {
    if (!(value <= worst)) worst = value;
  };
  // What the separation and a twist of rounding may add.
  constexpr double kNewtons = 1e-3, kRadians = 1e-6;
  const Sample& s = samples_[i];
  const Vec3& force = report.wrench.force;
  ++cycles_;
  late_ += (report.faults & kFaultTargetFar) != 0;
  faults_ += (report.faults & ~kFaultTargetFar) != 0;
  const double size = std::abs(force.norm() - tool_.stiffness * std::max(0.0, s.depth));
  worse(size_, size);
  worse(size_over_, std::max(0.0, size - s.bound.size - kNewtons));
  if (s.depth < shallow_) return;
  const double angle = std::atan2(force.cross(s.normal).norm(), force.dot(s.normal));
  worse(angle_, angle);
  worse(angle_over_, std::max(0.0, angle - s.bound.angle - kNewtons / force.norm()));
  const double torque = report.wrench.torque.norm();
  worse(torque_, torque);
  worse(torque_over_, std::max(0.0, torque - tool_.torsional * (s.bound.turn + kRadians)));
}

void CurvedJudge::Tell(Tally& tally) const {
  const double degrees = 180.0 / M_PI;
  tally.Count("slides", 1);
  tally.Count("over", !(angle_over_ <= 0.0 && size_over_ <= 0.0 && torque_over_ <= 0.0));
  tally.Most("angle deg", degrees * angle_);
  tally.Most("its over deg", degrees * angle_over_);
  tally.Most("size off N", size_);
  tally.Most("its over N", size_over_);
  tally.Most("torque N m", torque_);
  tally.Most("its over N m", torque_over_);
  tally.Count("cycles", cycles_);
  tally.Count("late", late_);
  tally.Count("faults", faults_);
}

void CurvedSlideJudge::See(std::size_t i, const StepReport& report) {
  late_ += (report.faults & kFaultTargetFar) != 0;
  unsolved_ += report.diagnostics.friction_unsolved > 0;
  yielded_ += report.diagnostics.friction_yielded > 0;
  if (i < steady_) return;
  Vec3 normal = report.X_WG.q * Vec3::UnitY();
  if (tool_.is_ball) {
    normal.setZero();
    for (int k = 0; k < report.contacts; ++k) {
      const ActiveRow& row = report.active[static_cast<std::size_t>(k)];
      normal += row.force * row.normal;
    }
    normal.normalize();
    const Vec3 smooth = X_WB_.q * body_->Nearest(X_WB_.Inverse() * report.X_WG.p).normal;
    const double over = std::atan2(normal.cross(smooth).norm(), normal.dot(smooth)) - bound_;
    if (!(over <= over_)) over_ = over;
  }
  const Vec3& force = report.wrench.force;
  const double load = force.dot(normal);
  const double mu = load > 0.0 ? (force - load * normal).norm() / load : 0.0;
  ++judged_;
  least_ = std::min(least_, mu);
  if (!(mu <= most_)) most_ = mu;
  off_ += !(std::abs(mu - kTruthDynamic) <= 0.01 * kTruthDynamic);
}

void CurvedSlideJudge::Tell(Tally& tally) const {
  tally.Count("slides", 1);
  tally.Count("1 % off", off_ > 0);
  tally.Least("mu least", least_);
  tally.Most("mu most", most_);
  tally.Most("over deg", 180.0 / M_PI * over_);
  tally.Count("cycles off", off_);
  tally.Count("judged", judged_);
  tally.Count("unsolved", unsolved_);
  tally.Count("yielded", yielded_);
  tally.Count("late", late_);
}

std::vector<TruthCase> CurvedTruths(bool million) {
  std::vector<TruthCase> cases;
  for (const bool rubs : {false, true}) {
    for (const std::string_view kind : test::kCurvedKinds) {
      for (const auto& [size, triangles] : kSizes) {
        if (triangles >= 1'000'000 && !million) continue;
        for (const std::string_view tool : kTools) {
          // The direction in which a pin's corners push is not known.
          if (rubs && tool == "pin") continue;
          const std::string name = std::string(rubs ? "curved-friction/" : "curved/") +
                                   std::string(kind) + "-" + std::string(size) + "/" +
                                   std::string(tool);
          cases.push_back({name, [=, count = triangles](std::uint64_t seed) {
                             return MakeHand(kind, count, tool, SeedOf(name, seed), rubs);
                           }});
        }
      }
    }
  }
  return cases;
}

}  // namespace palpate::bench
