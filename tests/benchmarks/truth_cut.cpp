// Burs that are pushed through bodies and drawn out.  The truth: a bur comes out with its hand; it
// never stands while its hand is away; and a hand that is back where it was has got no work.  And
// burs that mill while they tilt, which no hand need wait for.
#include <algorithm>
#include <array>
#include <cmath>

#include "common/math/rotation.h"
#include "scenes/shapes/bur_shapes.h"
#include "tests/benchmarks/truth.h"
#include "tests/benchmarks/truth_hands.h"
#include "tests/support/random.h"
#include "tests/support/test_scenes.h"

namespace palpate::bench {
namespace {

using test::Random;

constexpr double kPeriod = 1e-3;  // between two poses [s]

/// A tool's head.  It cuts with at most `strongest` times the pressure, however it moves.
struct Head {
  BurProfile profile;
  double length;     ///< [m]
  double strongest;  ///< its greatest section [m^2]
};

Head MakeHead(std::string_view tool, Random& random) {
  const double radius = random.Uniform(0.4e-3, 0.8e-3);
  if (tool == "ball") return {BallBur(radius), 2.0 * radius, M_PI * radius * radius};
  const double length = random.Uniform(2.0, 5.0) * radius;
  const double tip = tool == "cone" ? random.Uniform(0.4, 0.8) * radius : radius;
  return {ConeBur(tip, radius, length, random.Uniform(0.05, 1.0) * tip), length,
          std::max(2.0 * radius * length, M_PI * radius * radius)};
}

/// Poses of a hand that goes through a body and back, again and again.
struct Passes {
  std::vector<Pose> X_WH;
  std::vector<std::size_t> ends;  ///< for each pass, the sample at which the hand is back

  void Go(const Pose& to, double speed) {
    const Pose from = X_WH.back();
    const int steps = 1 + static_cast<int>((to.p - from.p).norm() / (speed * kPeriod));
    for (int i = 1; i <= steps; ++i) {
      const double part = double(i) / steps;
      X_WH.push_back({from.p + part * (to.p - from.p), from.q.slerp(part, to.q)});
    }
  }
};

/// Judges a bur on such a path.
class CutJudge {
 public:
  /// @param reference  of the tool, in its frame
  /// @param holds      how far material that it could cut may hold the tool from its hand [m]
  /// @param late       how many cycles may be late
  CutJudge(const Passes& passes, const Vec3& reference, double holds, double late = INFINITY)
      : X_WH_(passes.X_WH),
        ends_(passes.ends),
        reference_(reference),
        away_(std::max(0.5e-3, 1.5 * holds)),
        may_be_late_(late),
        X_WG_(X_WH_.front()) {}

  void See(std::size_t i, const StepReport& report) {
    constexpr double kStill = 1e-9;
    const Pose &now = X_WH_[i], &was = X_WH_[i == 0 ? 0 : i - 1];
    const Wrench& wrench = report.wrench;
    work_ += wrench.force.dot(now * reference_ - was * reference_) +
             wrench.torque.dot(RotationLog(now.q * was.q.conjugate()));
    const double away = (report.X_WG * reference_ - now * reference_).norm();
    const bool stands = (report.X_WG.p - X_WG_.p).norm() < kStill && away > away_;
    standing_ = stands ? standing_ + 1 : 0;
    stood_ += standing_ > kStillCycles;
    X_WG_ = report.X_WG;
    unsolved_ += (report.faults & kFaultUnsolved) != 0;
    jammed_ += (report.faults & kFaultJammed) != 0;
    late_ += (report.faults & kFaultTargetFar) != 0;
    if (pass_ == ends_.size() || i < ends_[pass_]) return;
    ++pass_;
    gained_ = std::max(gained_, work_);
    kept_ = std::max(kept_, wrench.force.norm());
    work_ = 0.0;
  }

  void Tell(Tally& tally) const {
    constexpr double kFelt = 0.01, kGain = 1e-6;  // [N], [J]
    const bool wrong = stood_ > 0 || unsolved_ > 0 || !(kept_ <= kFelt) || !(gained_ <= kGain) ||
                       late_ > may_be_late_;
    tally.Count("hands", 1);
    tally.Count("wrong", wrong);
    tally.Most("kept by N", kept_);
    tally.Most("gains uJ", 1e6 * gained_);
    tally.Count("stands", stood_);
    tally.Count("unsolved", unsolved_);
    tally.Count("jammed", jammed_);
    tally.Count("late", late_);
    tally.Count("cycles", double(X_WH_.size()));
  }

 private:
  static constexpr int kStillCycles = 20;
  std::vector<Pose> X_WH_;
  std::vector<std::size_t> ends_;
  Vec3 reference_;
  double away_;  ///< [m]
  double may_be_late_;
  Pose X_WG_;
  double work_ = 0.0;  ///< on the hand since the last pass [J]
  double gained_ = -INFINITY, kept_ = 0.0;
  std::size_t pass_ = 0;
  int standing_ = 0, stood_ = 0, unsolved_ = 0, jammed_ = 0, late_ = 0;
};

/// A body's size: along x it is long, y is up.
Vec3 SizeOf(std::string_view body, Random& random) {
  const double height = random.Uniform(0.3e-3, 1.2e-3);
  const double width = body == "sheet" ? 5e-3 : random.Uniform(0.3e-3, 1.2e-3);
  return {6e-3, height, width};
}

/// A hand that goes through and back where `places` say, in the body's frame.
Passes MakePasses(const Pose& X_WB, const Head& head, const std::vector<Vec3>& places,
                  Random& random) {
  constexpr double kAbove = 2e-3;
  Passes passes;
  for (const Vec3& place : places) {
    const Vec3 lean = random.Uniform(-0.5, 0.5) * Vec3(std::cos(random.Uniform(0.0, M_PI)), 0.0,
                                                       std::sin(random.Uniform(0.0, M_PI)));
    const Quat q = RotationExp(lean) * RotationExp(random.Uniform(-M_PI, M_PI) * Vec3::UnitY());
    // Nearly along the axis: a shank that leans on the wall would keep the tool from its hand.
    const Vec3 along = RotationExp(random.InCube(0.03)) * (q * Vec3::UnitY());
    const Pose above = X_WB * Pose{place + kAbove * along, q};
    const double through = head.length + random.Uniform(0.5e-3, 1.5e-3);
    const Pose below = X_WB * Pose{place - through * along, q};
    const double speed = random.Uniform(2e-3, 12e-3);
    if (passes.X_WH.empty()) passes.X_WH.push_back(above);
    passes.Go(above, 20e-3);
    passes.Go(below, speed);
    passes.Go(above, random.Uniform(0.5, 2.0) * speed);
    passes.ends.push_back(passes.X_WH.size() - 1);
  }
  return passes;
}

/// Places where a hand goes through: anywhere, or, for an island, twice beside it and then it.
std::vector<Vec3> PlacesOf(std::string_view body, const Vec3& size, double reach, Random& random) {
  std::vector<Vec3> places;
  // Where the bur meets an edge of a bar, it slips off beside it; its neck then leans on what is
  // left.
  const double beside = std::min(0.5 * size.z() + 0.3 * reach, 1.5e-3);
  const auto add = [&](double x) {
    places.push_back(
        Vec3(x, random.Uniform(-0.5, 0.5) * size.y(), random.Uniform(-beside, beside)));
  };
  if (body == "island") {
    const double half = reach + random.Uniform(0.1e-3, 0.6e-3);
    for (const double x : {-half, half}) add(x), places.back().z() = 0.0;
    add(random.Uniform(-half, half));
    return places;
  }
  for (int n = 0; n < 3; ++n) add(random.Uniform(-1.5e-3, 1.5e-3));
  return places;
}

/// A bur and a solid, which holds it by at most `most` [N].
Scene MakeScene(const Head& head, const Vec3& size, double& most, Random& random) {
  Scene scene;
  scene.name = "truth";
  Body bur = test::MakeSolidBody("bur", MakeBur(head.profile, 30e-3));
  bur.bur = head.profile;
  scene.tools.push_back(std::move(bur));
  Body solid = test::MakeSolidBody("solid", MakeBox(size));
  if (random.Below(2) == 0) solid.X_WB = {random.InCube(0.05), random.Rotation()};
  solid.grid.emplace().spacing = 50e-6;
  most = random.Uniform(0.2, 1.2);
  solid.materials = {{.cutting_pressure = most / head.strongest,
                      .cutting_viscosity = random.Below(2) * 20.0 * most / head.strongest}};
  scene.objects.push_back(std::move(solid));
  return scene;
}

TruthHand MakeCut(std::string_view body, std::string_view tool, std::uint64_t seed) {
  Random random(seed);
  const Head head = MakeHead(tool, random);
  const Vec3 size = SizeOf(body, random);
  double most;
  Scene scene = MakeScene(head, size, most, random);
  const double reach = std::sqrt(head.strongest / M_PI);
  const std::vector<Vec3> places = PlacesOf(body, size, std::min(reach, 0.8e-3), random);
  Passes passes = MakePasses(scene.objects.front().X_WB, head, places, random);
  CutJudge judge(passes, scene.tools.front().tree.centroid, most / scene.coupling.stiffness);
  return JudgedBy(std::move(judge), std::move(scene), std::move(passes.X_WH));
}

/// A hand that mills a block at 2 mm/s while it tilts the bur three times to and fro, about a place
/// near its tip.  The bur hardly moves, however far the handle goes, so it is never late.
TruthHand MakeMilling(std::string_view tool, std::uint64_t seed) {
  constexpr int kCycles = 2000;
  constexpr double kSpeed = 2e-3, kAbove = 0.5e-3;
  Random random(seed);
  const Head head = MakeHead(tool, random);
  const Vec3 size(8e-3, 6e-3, 6e-3);
  double most;
  Scene scene = MakeScene(head, size, most, random);
  const Pose& X_WB = scene.objects.front().X_WB;
  const double deep = 0.5 * size.y() - random.Uniform(0.5, 0.8) * head.length;
  const double high = 0.5 * size.y() + kAbove, pivot = random.Uniform(0.0, 1e-3);
  const double most_tilt = random.Uniform(0.5, 0.6), heading = random.Uniform(0.0, M_PI);
  const Vec3 axis(std::cos(heading), 0.0, std::sin(heading));
  const auto at = [&](double x, double y) {
    return X_WB * Pose{Vec3(x, y, 0.0), Quat::Identity()};
  };
  Passes passes;
  passes.X_WH.push_back(at(-2e-3, high));
  passes.Go(at(-2e-3, deep), kSpeed);
  for (int n = 1; n <= kCycles; ++n) {
    const double part = double(n) / kCycles;
    const Quat q = RotationExp(most_tilt * std::sin(3.0 * 2.0 * M_PI * part) * axis);
    const Vec3 up = pivot * Vec3::UnitY();
    passes.X_WH.push_back(X_WB *
                          Pose{Vec3(-2e-3 + kSpeed * kPeriod * n, deep, 0.0) + up - q * up, q});
  }
  passes.Go(at(-2e-3 + kSpeed * kPeriod * kCycles, high), kSpeed);
  passes.ends.push_back(passes.X_WH.size() - 1);
  CutJudge judge(passes, scene.tools.front().tree.centroid, most / scene.coupling.stiffness, 0.0);
  return JudgedBy(std::move(judge), std::move(scene), std::move(passes.X_WH));
}

}  // namespace

std::vector<TruthCase> CutTruths() {
  std::vector<TruthCase> cases;
  for (const std::string_view tool : {"cylinder", "cone"}) {
    const std::string name = "cut/tilt/" + std::string(tool);
    cases.push_back(
        {name, [=](std::uint64_t seed) { return MakeMilling(tool, SeedOf(name, seed)); }});
  }
  for (const std::string_view body : {"bar", "sheet", "island"}) {
    for (const std::string_view tool : {"ball", "cylinder", "cone"}) {
      const std::string name = "cut/" + std::string(body) + "/" + std::string(tool);
      cases.push_back(
          {name, [=](std::uint64_t seed) { return MakeCut(body, tool, SeedOf(name, seed)); }});
    }
  }
  return cases;
}

}  // namespace palpate::bench
