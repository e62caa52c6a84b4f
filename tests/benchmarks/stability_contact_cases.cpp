// Cases of hard geometry: the step alone, driven by hands more violent than a careful user's.
#include <algorithm>
#include <cmath>

#include <spdlog/fmt/fmt.h>

#include "common/math/rotation.h"
#include "server/physics/start_pose.h"
#include "tests/benchmarks/stability_case.h"
#include "tests/support/random.h"
#include "tests/support/test_trees.h"

namespace palpate::bench {
namespace {

using test::Random;

/// The figure of most cases: the overlap that Trial watches, in um.
void FigureIsOverlap(CaseRun& run) {
  run.figure = 1e6 * run.penetration;
}
constexpr const char* kOverlap = "deepest overlap at the resulting pose";
constexpr const char* kOverlapReason =
    "a pose without overlap exists, and 10 um is below what eye or hand can notice";

/// Makes a groove with an opening angle, its apex along z through the origin, open towards +y.
void Wedge(CaseRun& run, double degrees) {
  const double a = 0.5 * degrees * M_PI / 180.0;
  // Each wall extends 2 mm beyond the apex, inside or below the other, so that there is no gap.
  constexpr double kBeyond = 2 * kMillimetre;
  const Vec3 sides(50 * kMillimetre, 4 * kMillimetre, 24 * kMillimetre);
  std::vector<Solid> walls;
  std::vector<Vec3> inward;
  for (const double s : {1.0, -1.0}) {
    const Vec3 along(s * std::sin(a), std::cos(a), 0.0), normal(-s * std::cos(a), std::sin(a), 0.0);
    Mat3 R;
    R << along, normal, along.cross(normal);
    const Vec3 middle = (0.5 * sides.x() - kBeyond) * along - 0.5 * sides.y() * normal;
    walls.push_back(Box(sides, 1024, {middle, Quat(R)}));
    inward.push_back(normal);
  }
  Random random(static_cast<std::uint64_t>(degrees));
  const long end = run.steps;
  for (const bool ball : {true, false}) {
    // Tools that fit: a ball of 1 mm, and a box of 2 mm that may turn.
    const Solid tool = ball ? Ball(kMillimetre) : Box(Vec3::Constant(2 * kMillimetre), 64);
    const double rest = (ball ? 1.0 : std::sqrt(3.0)) * kMillimetre / std::sin(a);
    Trial trial(run, tool, walls);
    const Vec3 above(0.0, rest + 0.5 * kMillimetre, 0.0);
    trial.Start({above, Quat::Identity()});
    const Vec3 rate = 0.02 * random.InCube(1.0) + Vec3::Constant(0.03);  // [rad / ms]
    const long until = ball ? end / 2 : end;
    for (int i = 0; run.done < until; ++i) {
      // Presses up to 2.5 mm too deep and 2 mm into each side, and comes out again.
      const double in = std::min(1.0, 0.005 * i);
      const Vec3 sway(2 * std::sin(rate.x() * i), -1.0 + 2 * std::cos(0.3 * rate.y() * i),
                      6 * std::sin(0.2 * rate.z() * i));
      const Vec3 turn =
          0.4 * in * Vec3(std::sin(rate.y() * i), std::sin(rate.z() * i), std::sin(rate.x() * i));
      const StepReport report =
          trial.Step({above + in * kMillimetre * sway, RotationExp(ball ? Vec3::Zero() : turn)});
      for (const Vec3& normal : inward) run.tunnelled += normal.dot(report.X_WG.p) < 0.0;
    }
  }
  FigureIsOverlap(run);
}

Solid ThinPlate() {
  return Box({60 * kMillimetre, 0.5 * kMillimetre, 60 * kMillimetre}, 8192);
}

/// Pressed 20 mm into a plate of 0.5 mm, slowly to fast, dragged there, and let go.
void PressPlate(CaseRun& run, const Solid& tool) {
  Trial trial(run, tool, {ThinPlate()});
  constexpr double kAbove = 15 * kMillimetre, kDeep = -20 * kMillimetre;
  trial.Start({Vec3(0.0, kAbove, 0.0), Quat::Identity()});
  Random random(20);
  double speed = 0.5 * kMillimetre;  // a step: 0.5 m/s, then slower
  while (run.Goes()) {
    Vec3 at(0.0, kAbove, 0.0);
    const Vec3 drag = random.Uniform(0.2, 1.0) * Vec3(random.Direction().x(), 0, 1).normalized();
    const Vec3 axis = random.Direction();
    const int down = static_cast<int>((kAbove - kDeep) / speed), along = 20;
    for (int i = 0; i < 2 * (down + along); ++i) {
      if (i < down) at.y() -= speed;
      if (i >= down + 2 * along) at.y() += speed;
      if (i >= down && i < down + along) at += 0.5 * kMillimetre * drag;
      if (i >= down + along && i < down + 2 * along) at -= 0.5 * kMillimetre * drag;
      const double turn = tool.leaves == 1 ? 0.0 : 0.5 * std::sin(0.05 * i);
      const StepReport report = trial.Step({at, RotationExp(turn * axis)});
      run.tunnelled += report.X_WG.p.y() < 0.0;
    }
    speed = std::max(0.3 * speed, 0.01 * kMillimetre) + (speed < 0.02 * kMillimetre ? 5e-4 : 0.0);
  }
  FigureIsOverlap(run);
}

/// Hit from 30 mm away at 0.5 m/s, tilted and turning, from either side.
void HitPlate(CaseRun& run) {
  Trial trial(run, Box({8 * kMillimetre, 5 * kMillimetre, 12 * kMillimetre}, 512), {ThinPlate()});
  Random random(21);
  while (run.Goes()) {
    const double side = random.Below(2) == 0 ? 1.0 : -1.0;
    const Quat tilt = random.Rotation();
    const Vec3 spin = 0.02 * random.Direction();  // 20 rad/s
    const Vec3 slant = 0.2 * Vec3(random.Uniform(-1, 1), 0.0, random.Uniform(-1, 1));
    Vec3 at(0.0, side * 30 * kMillimetre, 0.0);
    trial.Start({at, tilt});
    for (int i = 0; i < 110; ++i) {
      at += 0.5 * kMillimetre * (slant - side * Vec3::UnitY()).normalized();
      const StepReport report =
          trial.Step({at, (RotationExp(static_cast<double>(i) * spin) * tilt).normalized()});
      run.tunnelled += side * report.X_WG.p.y() < 0.0;
    }
  }
  FigureIsOverlap(run);
}

/// A key of 4 mm in a slot 10 um wider, pushed in and drawn out while it is wrenched about.
void Slot(CaseRun& run) {
  constexpr double kWidth = 4 * kMillimetre + 10e-6;
  const Vec3 wall(10 * kMillimetre, 30 * kMillimetre, 30 * kMillimetre);
  const double off = 0.5 * (kWidth + wall.x());
  Trial trial(run, Box({4 * kMillimetre, 10 * kMillimetre, 10 * kMillimetre}, 1024),
              {Box(wall, 2048, {Vec3(off, 0, 0), Quat::Identity()}),
               Box(wall, 2048, {Vec3(-off, 0, 0), Quat::Identity()})});
  trial.Start({Vec3(0, 21 * kMillimetre, 0), Quat::Identity()});
  for (int i = 0; run.Goes(); ++i) {
    // It enters aligned, and is wrenched only once it is inside.
    const double y = 6.5 + 14.5 * std::cos(0.004 * i);
    const double in = std::clamp((18.0 - y) / 4.0, 0.0, 1.0);
    const Vec3 at(0.5 * in * std::sin(0.11 * i), y, 3 * in * std::sin(0.013 * i));
    const Vec3 turn = 0.05 * in * Vec3(std::sin(0.02 * i), std::sin(0.07 * i), std::cos(0.05 * i));
    const StepReport report = trial.Step({kMillimetre * at, RotationExp(turn)});
    run.tunnelled += std::abs(report.X_WG.p.x()) > 2 * kMillimetre;
  }
  FigureIsOverlap(run);
}

/// A square peg in a square hole that is 50 um wider: thousands of pairs within reach.
void PegInHole(CaseRun& run) {
  constexpr double kHole = 10 * kMillimetre + 50e-6, kWall = kMillimetre;
  const Vec3 wall(kHole + 2 * kWall, 40 * kMillimetre, kWall);
  const double off = 0.5 * (kHole + kWall);
  const Quat quarter(M_SQRT1_2, 0.0, M_SQRT1_2, 0.0);
  Trial trial(
      run, Box({10 * kMillimetre, 30 * kMillimetre, 10 * kMillimetre}, 1024),
      {Box(wall, 1024, {Vec3(0, 0, off), Quat::Identity()}),
       Box(wall, 1024, {Vec3(0, 0, -off), Quat::Identity()}),
       Box(wall, 1024, {Vec3(off, 0, 0), quarter}), Box(wall, 1024, {Vec3(-off, 0, 0), quarter})});
  trial.Start({});
  int most_rows = 0;
  for (int i = 0; run.Goes(); ++i) {
    const Vec3 at(0.8 * std::sin(0.21 * i), 8 * std::sin(0.03 * i), 0.8 * std::cos(0.17 * i));
    const double in = std::min(1.0, 0.01 * i);
    const Vec3 turn = 0.06 * in * Vec3(std::sin(0.05 * i), std::sin(0.07 * i), std::cos(0.03 * i));
    const StepReport report = trial.Step({in * kMillimetre * at, RotationExp(turn)});
    most_rows = std::max(most_rows, report.diagnostics.predicted_pairs);
    run.tunnelled += std::abs(report.X_WG.p.x()) > kMillimetre;
  }
  FigureIsOverlap(run);
  // Between meshes rows are added when violated, so there are never many.
  const bool spheres = run.features.contact == ContactModel::kSpheres;
  if (spheres && most_rows < 2000) run.figure = 1e9;  // not what the case is about
}

/// An object of a thousand copies of one ball under a tool of eight copies each of two others:
/// 8,000 equal rows.  The force must be that of one copy of each.
void Copies(CaseRun& run) {
  const test::Ball ball{Vec3::Zero(), 10 * kMillimetre}, probe{Vec3::Zero(), 5 * kMillimetre};
  const test::Ball far{Vec3(0, 60 * kMillimetre, 0), kMillimetre};  // gives it six freedoms
  struct Side {
    SphereTree tool, object;
    HapticModel model;
    StepWorkspace workspace;
    StepState state;
    Side(const std::vector<test::Ball>& tools, const std::vector<test::Ball>& objects)
        : tool(test::MakeTree(tools)),
          object(test::MakeTree(objects)),
          model(tool, Forest(object), {}),
          workspace(model) {}
    static std::shared_ptr<const SceneObjects> Forest(const SphereTree& object) {
      PlacedTree placed;
      placed.tree = &object;
      return std::make_shared<const SceneObjects>(std::span(&placed, 1));
    }
  };
  std::vector<test::Ball> probes(8, probe);
  probes.insert(probes.end(), 8, far);
  Side many(probes, std::vector<test::Ball>(1000, ball)), one({probe, far}, {ball});
  const Vec3 touch(0, 15 * kMillimetre, 0);
  many.state.X_WG = one.state.X_WG = {touch + Vec3(0, kMillimetre, 0), Quat::Identity()};
  for (int i = 0; run.Goes(); ++i) {
    if (run.stopped && run.stopped()) throw Interrupted{};
    const Vec3 at(2 * std::sin(0.01 * i), std::cos(0.023 * i), 2 * std::sin(0.017 * i));
    const Pose X_WH{touch + kMillimetre * at, Quat::Identity()};
    const StepReport report = HapticStep(many.model, X_WH, many.state, many.workspace);
    const StepReport single = HapticStep(one.model, X_WH, one.state, one.workspace);
    ++run.done;
    run.nonfinite += !(report.X_WG.p.allFinite() && report.wrench.force.allFinite());
    for (const test::Ball& t : {probe, far}) {
      run.penetration = std::max(
          run.penetration, t.radius + ball.radius - (report.X_WG * t.center - ball.center).norm());
    }
    run.Worst((report.wrench.force - single.wrench.force).norm());
  }
}

/// A box on a plate, turned ten times and more about every axis, through beta = +-90 degrees, with
/// q and -q for the same pose alternately: the sign must make no difference.
void Orientations(CaseRun& run) {
  const Solid tool = Box({12 * kMillimetre, 6 * kMillimetre, 9 * kMillimetre}, 256);
  const Solid plate = Box({80 * kMillimetre, 10 * kMillimetre, 80 * kMillimetre}, 2048);
  Trial trial(run, tool, {plate}), flipped(run, tool, {plate});
  const Vec3 rest(0, 15 * kMillimetre, 0);
  trial.Start({rest, Quat::Identity()});
  flipped.Start({rest, Quat::Identity()});
  Quat q = Quat::Identity();
  for (int i = 0; run.Goes(); ++i) {
    // 6 rad/s about an axis that changes slowly: each second a full turn, about x, y and z alike.
    const double phase = 0.0009 * i;
    const Vec3 axis(std::sin(phase), std::cos(phase), std::sin(1.7 * phase));
    q = (RotationExp(0.006 * axis.normalized()) * q).normalized();
    Pose X_WH{rest - Vec3(0, (4.0 + 3.0 * std::sin(0.01 * i)) * kMillimetre, 0), q};
    const Wrench wrench = trial.Step(X_WH).wrench;
    if (i % 2 == 1) X_WH.q.coeffs() *= -1.0;
    const StepReport other = flipped.Step(X_WH);
    run.tunnelled += other.X_WG.p.y() < 5 * kMillimetre;
    run.Worst(std::max((other.wrench.force - wrench.force).norm(),
                       (other.wrench.torque - wrench.torque).norm()));
  }
}

/// The target jumps up to 50 mm and 90 degrees in one step, through a plate or back, and stays
/// there for a while or not.
void Jumps(CaseRun& run) {
  Trial trial(run, Box({10 * kMillimetre, 6 * kMillimetre, 8 * kMillimetre}, 256),
              {Box({160 * kMillimetre, 0.5 * kMillimetre, 160 * kMillimetre}, 16384)});
  Random random(50);
  Pose X_WH{Vec3(0, 20 * kMillimetre, 0), Quat::Identity()};
  trial.Start(X_WH);
  while (run.Goes()) {
    const Vec3 jump = 50 * kMillimetre * random.Direction();
    const Vec3 to = X_WH.p + jump;
    const bool far_out =
        std::abs(to.x()) > 0.04 || std::abs(to.z()) > 0.04 || std::abs(to.y()) > 0.06;
    X_WH.p = far_out ? Vec3(Vec3(0, to.y() > 0 ? 0.03 : -0.02, 0)) : to;
    X_WH.q = (RotationExp(M_PI / 2 * random.Direction()) * X_WH.q).normalized();
    for (int stay = random.Below(40); stay >= 0; --stay) {
      run.tunnelled += trial.Step(X_WH).X_WG.p.y() < 0.0;
    }
  }
  FigureIsOverlap(run);
}

/// Starts the tool anywhere inside a cube: it must come out before a force is felt, and the force
/// is then at most the spring's over the distance to where it came out.
void StartInside(CaseRun& run) {
  Trial trial(run, Box({10 * kMillimetre, 6 * kMillimetre, 8 * kMillimetre}, 256),
              {Box(Vec3::Constant(50 * kMillimetre), 2048)});
  Random random(51);
  while (run.Goes()) {
    Pose X_WH{random.InCube(24 * kMillimetre), random.Rotation()};
    const StartPose start = ResolveStart(trial.model(), X_WH, trial.workspace());
    run.penetration = std::max(run.penetration, trial.Overlap(start.X_WG));
    trial.Start(start.X_WG);
    for (int i = 0; i < 50; ++i) {
      const double force = trial.Step(X_WH).wrench.force.norm();
      run.tunnelled += force > 1000.0 * (start.depth + 5 * kMillimetre);
    }
  }
  FigureIsOverlap(run);
}

/// Drives a jammed tool: wrenched for 400 ms, then drawn out along +y.  At its deepest in both
/// sides it overlaps each by half of `excess`.  With sphere contact the overlap must be shared;
/// with meshes none is allowed, so the tool begins at the resolved start pose.  The force must be
/// the spring's, and once out the tool must be free.
void DriveJam(CaseRun& run, Trial& trial, double excess) {
  trial.ExpectFree(false);
  Random random(52);
  const bool meshes = run.features.contact == ContactModel::kSurface;
  while (run.Goes()) {
    const Pose X_in{Vec3(random.Uniform(-20e-6, 20e-6), 0, 0), Quat::Identity()};
    trial.Start(meshes ? ResolveStart(trial.model(), X_in, trial.workspace()).X_WG : X_in);
    const Vec3 pull(random.Uniform(-5, 5), random.Uniform(0, 5), random.Uniform(-5, 5));
    const Vec3 turn = 0.3 * random.Direction();
    for (int i = 0; i < 700; ++i) {
      const double in = std::clamp(0.005 * (400 - i), 0.0, 1.0) * std::min(1.0, 0.01 * i);
      const Vec3 out(0, 0.1 * std::max(0, i - 400), 0);
      const Pose X_WH{kMillimetre * (in * pull + out), RotationExp(in * turn)};
      const StepReport report = trial.Step(X_WH);
      run.Worst(1e6 * (trial.Overlap(report.X_WG) - (meshes ? 0.0 : 0.5 * excess)));
      const double way = (X_WH.p - report.X_WG.p).norm();
      // While it leaves the overlap, the tool may feel its target, a millimetre further.
      const bool arrived = (report.faults & kFaultTargetFar) == 0;
      run.tunnelled +=
          report.wrench.force.norm() > 1000.0 * (way + (arrived ? excess : kMillimetre));
      if (i < 699) continue;
      run.penetration = std::max(run.penetration, trial.Overlap(report.X_WG));
      run.tunnelled += !report.wrench.force.isZero(0.0) || (report.X_WG.p - X_WH.p).norm() > 1e-9;
    }
  }
}

/// A ball of 4 mm between two balls that leave 3.9 mm.
void JamBetweenEars(CaseRun& run) {
  constexpr double kExcess = 0.1 * kMillimetre, kEar = 10 * kMillimetre;
  const double off = kEar + 2 * kMillimetre - 0.5 * kExcess;
  Trial trial(run, Ball(2 * kMillimetre),
              {Ball(kEar, 1, {Vec3(off, 0, 0), Quat::Identity()}),
               Ball(kEar, 1, {Vec3(-off, 0, 0), Quat::Identity()})});
  DriveJam(run, trial, kExcess);
}

/// A key of 4 mm in a slot of 3.9 mm.  With contact between spheres a press fit like this one holds
/// for ever, because their bumps interlock; flat faces let it go.
void JamInSlot(CaseRun& run) {
  constexpr double kExcess = 0.1 * kMillimetre, kKey = 4 * kMillimetre;
  const Vec3 wall(10 * kMillimetre, 30 * kMillimetre, 30 * kMillimetre);
  const double off = 0.5 * (kKey - kExcess + wall.x());
  Trial trial(run, Box({kKey, 10 * kMillimetre, 10 * kMillimetre}, 1024),
              {Box(wall, 2048, {Vec3(off, 0, 0), Quat::Identity()}),
               Box(wall, 2048, {Vec3(-off, 0, 0), Quat::Identity()})});
  DriveJam(run, trial, kExcess);
}

/// A cube of one size and a ball a tenth of it, pressed a fiftieth deep, dragged and lifted.
void Sizes(CaseRun& run) {
  const double sizes[] = {1e-3, 1e-2, 0.1, 1.0, 10.0};
  const long each = run.steps / 5;
  for (int k = 0; k < 5; ++k) {
    const double size = sizes[k], radius = 0.1 * size;
    Trial trial(run, Ball(radius), {Box(Vec3::Constant(size), 4096)});
    // No faster than a hand at any size.
    const double swing = std::min(0.02 * size, 0.02);
    const Vec3 touch(0, 0.5 * size + radius, 0);
    trial.Start({touch + Vec3(0, swing, 0), Quat::Identity()});
    for (int i = 0; run.done < (k + 1) * each; ++i) {
      const Vec3 at(5 * std::sin(0.003 * i), std::cos(0.01 * i), 5 * std::sin(0.002 * i));
      const StepReport report = trial.StepTo(touch + swing * at);
      run.tunnelled += report.X_WG.p.y() < 0.5 * size;
    }
  }
  FigureIsOverlap(run);
}

}  // namespace

std::vector<StabilityCase> ContactCases() {
  std::vector<StabilityCase> cases;
  const auto overlap = [&](const std::string& name, double share, auto run) {
    cases.push_back({.name = name,
                     .what = kOverlap,
                     .reason = kOverlapReason,
                     .bound = 1e6 * kAllowedOverlap,
                     .unit = "um",
                     .share = share,
                     .run = run});
  };
  for (const int degrees : {5, 15, 30, 60, 90, 120, 150, 175}) {
    overlap(fmt::format("wedge-{}", degrees), 0.5, [=](CaseRun& run) { Wedge(run, degrees); });
  }
  overlap("thin-plate-ball", 1, [](CaseRun& run) { PressPlate(run, Ball(5 * kMillimetre)); });
  overlap("thin-plate-box", 1, [](CaseRun& run) {
    PressPlate(run, Box({8 * kMillimetre, 5 * kMillimetre, 12 * kMillimetre}, 512));
  });
  overlap("thin-plate-hit", 1, HitPlate);
  overlap("slot-10um", 1, Slot);
  overlap("peg-in-hole", 0.5, PegInHole);
  cases.push_back({.name = "thousand-copies",
                   .what = "force less that of single copies",
                   .reason = "copies forbid what one forbids; 1 nm of rounding is 1e-6 N",
                   .bound = 1e-6,
                   .unit = "N",
                   .share = 0.2,
                   .run = Copies});
  cases.push_back({.name = "orientations",
                   .what = "wrench of -q less wrench of q, N and N m",
                   .reason = "q and -q are one pose: not a bit may differ",
                   .bound = 0.0,
                   .unit = "N",
                   .share = 1.5,
                   .run = Orientations});
  overlap("target-jumps", 1, Jumps);
  overlap("start-inside", 0.2, StartInside);
  const auto jam = [&](const std::string& name, auto run, auto applies) {
    cases.push_back({.name = name,
                     .what = "overlap beyond half of what the tool is too wide",
                     .reason = "both sides share what must overlap, so that neither gets more",
                     .bound = 1e6 * kAllowedOverlap,
                     .unit = "um",
                     .share = 0.5,
                     .least = 1400,
                     .run = run,
                     .applies = applies});
  };
  // Between meshes the tool never enters, so there is no overlap to share.
  jam("jam-between-ears", JamBetweenEars,
      [](const Features& f) { return f.contact == ContactModel::kSpheres; });
  jam("jam-in-slot", JamInSlot,
      [](const Features& f) { return f.contact == ContactModel::kSurface; });
  overlap("sizes", 1, Sizes);
  return cases;
}

}  // namespace palpate::bench
