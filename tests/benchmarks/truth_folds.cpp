// Tools in V-grooves and prisms in their holes.  The truth is that of the plane across
// (tests/support/planar_rest.h): what lies in a groove or hole is held by its flat sides alone, and
// symmetric about the plane z = const of its centroid, so that nothing turns it out of that plane.
//   - Without friction: no force along z.  Across, the nearest free place to the hand: in a groove
//     the spring's force is shared by both sides as the span of their normals says, for the ball
//     and the level tool in its middle load / (2 sin a) on each.
//   - Sliding along z: friction mu_d times the sum of the loads, in the middle mu_d load / sin a.
#include "tests/benchmarks/truth_folds.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/math/rotation.h"
#include "tests/benchmarks/truth.h"
#include "tests/benchmarks/truth_hands.h"
#include "tests/support/flat_plates.h"
#include "tests/support/folded_plates.h"
#include "tests/support/sharp_bodies.h"
#include "tests/support/test_scenes.h"

namespace palpate::bench {
namespace {

using test::Random;
using test::Vec2;

std::vector<Vec3> RegularOutline(Random& random) {
  constexpr int kCorners[] = {3, 4, 6, 8, 12};
  const int n = kCorners[random.Below(5)];
  const double radius = random.Uniform(0.008, 0.015);
  std::vector<Vec3> outline;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * M_PI * i / n;
    outline.push_back(radius * Vec3(std::cos(angle), std::sin(angle), 0.0));
  }
  return outline;
}

std::vector<Vec3> UnequalOutline(Random& random) {
  const int n = 4 + random.Below(4);
  const double x = random.Uniform(0.008, 0.015), y = x * random.Uniform(0.6, 1.0);
  std::vector<Vec3> outline;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * M_PI * (i + random.Uniform(-0.25, 0.25)) / n;
    outline.push_back({x * std::cos(angle), y * std::sin(angle), 0.0});
  }
  return outline;
}

/// Returns the corners of an extruded outline, from the body's centroid.
std::vector<Vec3> OutlineOf(const Body& prism) {
  std::vector<Vec3> outline;
  for (std::size_t i = 0; i < prism.mesh.vertices.size() / 2; ++i) {
    const Vec3 v = prism.mesh.vertices[i] - prism.tree.centroid;
    outline.push_back({v.x(), v.y(), 0.0});
  }
  return outline;
}

/// Returns the outline of a hole that is wider than a convex outline by a gap on each side.
std::vector<Vec3> Widened(const std::vector<Vec3>& outline, double gap) {
  const std::size_t n = outline.size();
  const auto outward = [&](std::size_t i) {
    const Vec3 side = outline[(i + 1) % n] - outline[i % n];
    return Vec3(side.y(), -side.x(), 0.0).normalized();
  };
  std::vector<Vec3> wide;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 a = outward(i + n - 1), b = outward(i);
    wide.push_back(outline[i] + gap / (1.0 + a.dot(b)) * (a + b));
  }
  return wide;
}

/// Makes a bar along z with the outline of a tool that lies in a groove.
std::vector<Vec3> BarOutline(std::string_view tool, double half_angle, Random& random) {
  const double x = random.Uniform(0.005, 0.012), y = random.Uniform(0.005, 0.012);
  if (tool == "wedge") {
    const double s = x * std::sin(half_angle), c = x * std::cos(half_angle);
    return {{0.0, 0.0, 0.0}, {s, c, 0.0}, {-s, c, 0.0}};
  }
  if (tool == "edge") return {{0.0, -x, 0.0}, {x, 0.0, 0.0}, {0.0, x, 0.0}, {-x, 0.0, 0.0}};
  return {{-x, -y, 0.0}, {x, -y, 0.0}, {x, y, 0.0}, {-x, y, 0.0}};
}

Pose PoseOf(const Vec3& centroid, const FoldSample& sample) {
  const Quat q = RotationExp(sample.angle * Vec3::UnitZ());
  return {Vec3(sample.at.x(), sample.at.y(), sample.z) - q * centroid, q};
}

/// Returns how high above its groove's bottom the centroid of a level tool is in the middle.
double BottomOf(const test::PlanarFit& fit) {
  return OutBy(fit, Vec2::Zero(), 0.0) / fit.sides[0].normal.y();
}

struct FoldMotion {
  double depth, speed, swing;          ///< of the hand along z: [m/s], and how far to each side [m]
  double lean = 0.0, lean_Hz = 0.0;    ///< across, as a part of the depth
  double aside = 0.0, aside_Hz = 0.0;  ///< direction in which a peg is pushed [rad]
  bool is_pushed = true;               ///< else a peg is in the middle
  double turn = 0.0, turn_Hz = 1.3;    ///< about z [rad]
};

FoldMotion MakeMotion(std::string_view tool, bool rubs, Random& random) {
  const bool is_peg = tool == "peg" || tool == "prism";
  FoldMotion m{};
  m.depth = Decades(random, 5e-4, rubs ? 2e-3 : 10e-3);
  m.speed = Decades(random, rubs ? 5e-3 : 1e-3, 0.1);
  m.swing = random.Uniform(0.005, 0.015);
  const int leans = random.Below(3), turns = random.Below(3);
  const double lean = random.Uniform(-1.5, 1.5), turn = random.Uniform(0.02, 0.1);
  m.aside = random.Uniform(-M_PI, M_PI);
  // Only what its groove cannot turn stays level if it is not pressed in the middle.
  if (leans > 0 && (!rubs || tool == "ball" || tool == "wedge")) m.lean = lean;
  if (leans > 1 && !rubs) m.lean_Hz = m.aside_Hz = 0.7;
  if (rubs) return m;
  m.is_pushed = leans > 0;
  if (tool != "ball" && turns > 0) m.turn = is_peg ? turn : 0.5 * turn;
  return m;
}

/// @param bottom  height of the tool's centroid at the groove's bottom.
/// @param depth  of the hand [m].   @param i  the step, for what swings.
FoldSample SampleAt(const FoldMotion& m, double bottom, bool is_peg, double depth, int i = 0) {
  const double t = 1e-3 * i, pressed = std::clamp(depth / m.depth, 0.0, 1.0);
  const double swings = m.speed / m.swing * 1e-3 * std::max(0, i - kDown);
  FoldSample s{Vec2::Zero(), m.turn * std::sin(2.0 * M_PI * m.turn_Hz * t) * pressed,
               m.swing * std::sin(swings)};
  if (is_peg) {
    const double aside = m.aside + 2.0 * M_PI * m.aside_Hz * t;
    if (m.is_pushed) s.at = std::max(0.0, depth) * Vec2(std::cos(aside), std::sin(aside));
    return s;
  }
  const double lean = m.lean * (m.lean_Hz > 0.0 ? std::sin(2.0 * M_PI * m.lean_Hz * t) : 1.0);
  s.at = {lean * m.depth * pressed, bottom - depth};
  return s;
}

Vec3 Pull(const test::PlanarFit& fit, const test::PlanarRest& rest, const Vec2& hand) {
  const Vec2 pull = fit.stiffness * (rest.at - hand);
  return {pull.x(), pull.y(), 0.0};
}

SmoothTruth TruthOf(const test::PlanarFit& fit, const Quat& q_WB,
                    const std::vector<FoldSample>& hand) {
  SmoothTruth truth{.axis = {q_WB * Vec3::UnitZ()}, .across = true};
  for (const FoldSample& s : hand) {
    const test::PlanarRest rest = RestOf(fit, s.at, s.angle);
    truth.force.push_back(q_WB * Pull(fit, rest, s.at));
    truth.torque.push_back(fit.torsional * (rest.angle - s.angle) * truth.axis.front());
  }
  return truth;
}

/// Returns by how much static friction that points inward can raise the loads of a tool that is
/// pressed between two sides, s / (s - mu_s c) for their half angle.  Up to then it may stick.
double WedgeGain(const test::PlanarFit& fit, const test::PlanarRest& rest) {
  if (rest.holds.size() < 2) return 1.0;
  const double both = fit.sides[static_cast<std::size_t>(rest.holds[0])].normal.dot(
      fit.sides[static_cast<std::size_t>(rest.holds[1])].normal);
  const double s = std::sqrt(0.5 * (1.0 + both)), c = std::sqrt(0.5 * (1.0 - both));
  return s > kTruthStatic * c ? s / (s - kTruthStatic * c) : INFINITY;
}
constexpr double kMostWedged = 2.1;  // sides at right angles: 2

/// A slide along z in steps of the hand's speed, which begins where it leaves room for all of it.
TruthHand MakeSlide(const Fold& fold, Scene scene, FoldMotion motion, double bottom) {
  const bool is_peg = fold.gap > 0.0;
  const Pose& X_WB = fold.object.X_WB;
  const Vec3 along = X_WB.q * Vec3::UnitZ();
  SteadySlide slide{.normals = {},
                    .along = along,
                    .speed = motion.speed,
                    .reach = ReachOf(fold.tool),
                    .stiffness = fold.fit.stiffness,
                    .steady = 0,
                    .depth = {}};
  // The tremor is along the pull, so that it changes the force alone.
  FoldSample deep = SampleAt(motion, bottom, is_peg, motion.depth);
  test::PlanarRest rest = RestOf(fold.fit, deep.at, deep.angle);
  if (rest.holds.size() == 2 && !(WedgeGain(fold.fit, rest) < kMostWedged)) {
    // Against one side instead.
    const Vec2& n = fold.fit.sides[0].normal;
    motion.aside = std::atan2(-n.y(), -n.x());
    deep = SampleAt(motion, bottom, is_peg, motion.depth);
    rest = RestOf(fold.fit, deep.at, deep.angle);
  }
  const Vec2 pull = rest.at - deep.at;
  double load = 0.0;
  for (std::size_t k = 0; k < rest.holds.size(); ++k) {
    const Vec2& n = fold.fit.sides[static_cast<std::size_t>(rest.holds[k])].normal;
    slide.normals.push_back(X_WB.q * Vec3(n.x(), n.y(), 0.0));
    load += rest.load[k];
  }
  slide.gain = load / (fold.fit.stiffness * pull.norm());
  const double pressed = slide.gain * motion.depth * std::hypot(1.0, motion.lean);
  const double run_in =
      (kTruthStatic * WedgeGain(fold.fit, rest) + 8.0 * kTruthDynamic) * pressed + 3e-4;
  slide.steady = static_cast<std::size_t>(kDown + std::ceil(1e3 * run_in / motion.speed));
  const int steps = static_cast<int>(std::min(static_cast<double>(slide.steady) + 600.0,
                                              kDown + 1e3 * (run_in + 4e-3) / motion.speed));
  std::vector<Pose> X_WH;
  std::vector<Vec3> across;
  for (int i = 0; i < steps; ++i) {
    const double depth = DepthAt(i, motion.depth);
    FoldSample s = i < kDown ? SampleAt(motion, bottom, is_peg, depth) : deep;
    if (i >= kDown) s.at += (motion.depth - depth) * pull.normalized();
    s.z = 1e-3 * motion.speed * std::max(0, i - kDown) - 0.5 * run_in;
    across.push_back(X_WB.q * Pull(fold.fit, RestOf(fold.fit, s.at, s.angle), s.at));
    slide.depth.push_back(depth);
    X_WH.push_back(X_WB * PoseOf(fold.tool.tree.centroid, s));
  }
  const Quat start = X_WH.front().q;
  return JudgedBy(FoldSlideJudge(std::move(slide), start, std::move(across)), std::move(scene),
                  std::move(X_WH));
}

TruthHand MakeHand(std::string_view tessellation, std::string_view tool, std::uint64_t seed,
                   bool rubs) {
  Random random(seed);
  Fold fold = MakeFold(tessellation, tool, rubs, random);
  const FoldMotion motion = MakeMotion(tool, rubs, random);
  if (random.Below(2) == 0) fold.object.X_WB = {random.InCube(0.2), random.Rotation()};
  if (rubs) {
    fold.object.materials = {{.static_friction = kTruthStatic, .dynamic_friction = kTruthDynamic}};
  }
  Scene scene;
  scene.name = "truth";
  if (rubs) scene.features.friction = FrictionModel::kCoulomb;
  scene.tools = {fold.tool};
  scene.objects = {fold.object};
  const bool is_peg = fold.gap > 0.0;
  const double bottom = is_peg ? 0.0 : BottomOf(fold.fit);
  if (rubs) return MakeSlide(fold, std::move(scene), motion, bottom);
  std::vector<FoldSample> hand;
  std::vector<Pose> X_WH;
  for (int i = 0; i < kDown + 700; ++i) {
    hand.push_back(SampleAt(motion, bottom, is_peg, DepthAt(i, motion.depth), i));
    X_WH.push_back(fold.object.X_WB * PoseOf(fold.tool.tree.centroid, hand.back()));
  }
  FoldJudge judge(fold, scene, hand);
  return JudgedBy(std::move(judge), std::move(scene), std::move(X_WH));
}

}  // namespace

Fold MakeFold(std::string_view tessellation, std::string_view tool, bool rubs, Random& random) {
  const Coupling coupling;
  const double separation = StepTuning{}.separation;
  Fold fold;
  fold.fit = {{}, {}, coupling.stiffness, coupling.torsional_stiffness};
  if (tool == "peg" || tool == "prism") {
    const std::vector<Vec3> outline =
        tool == "peg" ? RegularOutline(random) : UnequalOutline(random);
    fold.gap = Decades(random, 5e-6, 1e-4);
    // So long that friction at a side cannot tip it.
    fold.tool = test::MakeSolidBody(
        std::string(tool), test::Extruded(outline, random.Uniform(1.5, 2.5) * outline[0].norm()));
    const std::vector<Vec3> narrow = OutlineOf(fold.tool), wide = Widened(narrow, fold.gap);
    for (std::size_t i = 0; i < wide.size(); ++i) {
      const Vec3 side = wide[(i + 1) % wide.size()] - wide[i];
      const Vec2 inward = Vec2(-side.y(), side.x()).normalized();
      fold.fit.sides.push_back({inward, inward.dot(wide[i].head<2>()) + separation});
      fold.fit.outline.push_back(narrow[i].head<2>());
    }
    fold.object = SurfaceBody("hole", test::MakeHole(tessellation, wide, random.Bits()));
    return fold;
  }
  // An edge of a right angle needs a wider groove, and what slides with friction one in which it is
  // not wedged.  Sides that meet at less than 40 degrees, above
  // 1.22, are to a ball those of a smooth surface.
  const double half_angle = random.Uniform(tool == "edge" || rubs ? 0.9 : 0.5, 1.2);
  double radius = 0.0;
  if (tool == "ball") {
    radius = random.Uniform(0.001, 0.008);
    fold.tool = test::BallBody(radius);
    fold.fit.outline = {Vec2::Zero()};
  } else {
    fold.tool = test::MakeSolidBody(
        std::string(tool),
        test::Extruded(BarOutline(tool, half_angle, random), random.Uniform(0.008, 0.02)));
    for (const Vec3& v : OutlineOf(fold.tool)) fold.fit.outline.push_back(v.head<2>());
  }
  const double s = std::sin(half_angle), c = std::cos(half_angle);
  for (const double side : {1.0, -1.0}) {
    fold.fit.sides.push_back({Vec2(-side * c, s), radius + separation});
  }
  const std::uint64_t right = random.Bits(), left = random.Below(2) == 0 ? right : random.Bits();
  fold.object = SurfaceBody("groove", test::MakeGroove(tessellation, half_angle, right, left));
  return fold;
}

FoldJudge::FoldJudge(const Fold& fold, const Scene& scene, const std::vector<FoldSample>& hand)
    : fit_(fold.fit),
      centroid_(fold.tool.tree.centroid),
      X_BW_(scene.objects.front().X_WB.Inverse()),
      smooth_(TruthOf(fold.fit, scene.objects.front().X_WB.q, hand)) {}

void FoldJudge::See(std::size_t i, const StepReport& report) {
  smooth_.See(i, report);
  const Pose X_BG = X_BW_ * report.X_WG;
  const Vec3 at = X_BG * centroid_;
  const double out = OutBy(fit_, at.head<2>(), RotationLog(X_BG.q).z());
  if (!(out <= out_)) out_ = out;
}

void FoldJudge::Tell(Tally& tally) const {
  smooth_.Tell(tally);
  tally.Most("out um", 1e6 * out_);
}

void FoldSlideJudge::See(std::size_t i, const StepReport& report) {
  steady_.See(i, report);
  if (i < steady_from_) return;
  const Vec3& force = report.wrench.force;
  const double off = (force - force.dot(along_) * along_ - across_[i]).norm();
  if (!(off <= off_)) off_ = off;
}

void FoldSlideJudge::Tell(Tally& tally) const {
  steady_.Tell(tally);
  tally.Most("across off N", off_);
}

std::vector<TruthCase> FoldTruths() {
  std::vector<TruthCase> cases;
  for (const bool rubs : {false, true}) {
    for (const std::string_view plate : test::kTessellations) {
      for (const std::string_view tool : kFolded) {
        const std::string name =
            (rubs ? "folds-friction/" : "folds/") + std::string(plate) + "/" + std::string(tool);
        cases.push_back({name, [=](std::uint64_t seed) {
                           return MakeHand(plate, tool, SeedOf(name, seed), rubs);
                         }});
      }
    }
  }
  return cases;
}

}  // namespace palpate::bench
