// Cases of a hand at rest or in slow motion: noise, drift, creep, friction, flatness.
#include <algorithm>
#include <cmath>

#include "common/math/rotation.h"
#include "tests/benchmarks/stability_case.h"
#include "tests/support/random.h"

namespace palpate::bench {
namespace {

using test::Random;

constexpr double kStiffness = 1000.0;

bool Surface(const Features& features) {
  return features.contact == ContactModel::kSurface;
}
bool Smooth(const Features& features) {
  return Surface(features) && features.friction == FrictionModel::kOff;
}

/// A plate whose top face is y = 0.
Solid Floor(std::size_t leaves = 4096) {
  return Box({60 * kMillimetre, 10 * kMillimetre, 60 * kMillimetre}, leaves,
             {Vec3(0, -5 * kMillimetre, 0), Quat::Identity()});
}

/// Encoder noise in contact.  The god-object is the nearest free pose, and the residual of a
/// projection onto a convex set moves no further than the projected point.  So the greatest change
/// of force is at most the stiffness times the greatest change of the hand.
void Noise(CaseRun& run) {
  Trial trial(run, Ball(5 * kMillimetre), {Floor()});
  Random random(60);
  const Vec3 rest(0, 4 * kMillimetre, 0);  // 1 mm deep
  trial.Start({Vec3(0, 6 * kMillimetre, 0), Quat::Identity()});
  Vec3 force, hand = rest;
  for (int i = 0; i < 100; ++i) force = trial.StepTo(rest).wrench.force;
  double greatest_change = 0.0, greatest_move = 0.0;
  while (run.Goes()) {
    const Vec3 last_force = force, last_hand = hand;
    hand = rest + random.InCube(20e-6);
    force = trial.StepTo(hand).wrench.force;
    greatest_change = std::max(greatest_change, (force - last_force).norm());
    greatest_move = std::max(greatest_move, (hand - last_hand).norm());
  }
  run.figure = greatest_change / (kStiffness * greatest_move);
}

/// Repeats a round trip of 1,000 steps, pressed, in six degrees of freedom: at each point of a
/// round the tool must be where it was in the second round.
void Drift(CaseRun& run) {
  Trial trial(run, Box({12 * kMillimetre, 6 * kMillimetre, 9 * kMillimetre}, 256), {Floor(2048)});
  constexpr int kRound = 1000;
  std::vector<Pose> second(kRound);
  trial.Start({Vec3(0, 12 * kMillimetre, 0), Quat::Identity()});
  for (long i = 0; run.Goes() || i < 3 * kRound; ++i) {
    const double a = 2 * M_PI * static_cast<double>(i % kRound) / kRound;
    const Vec3 at(6 * std::sin(a), 5 + 4 * std::cos(a), 4 * std::sin(2 * a));
    const Vec3 turn = 0.4 * Vec3(std::sin(a), std::sin(2 * a), std::cos(a));
    const Pose X_WG = trial.Step({kMillimetre * at, RotationExp(turn)}).X_WG;
    const auto phase = static_cast<std::size_t>(i % kRound);
    if (i / kRound == 1) second[phase] = X_WG;
    if (i / kRound < 2) continue;
    run.Worst(1e6 * (X_WG.p - second[phase].p).norm());
    run.tunnelled += std::abs(X_WG.q.norm() - 1.0) > 1e-12;
  }
}

/// A box pressed flat on a plate with 1 N at its centre: it must lie flat, and feel no torque.
void RestFlat(CaseRun& run, double speed) {
  const Vec3 sides(20 * kMillimetre, 6 * kMillimetre, 14 * kMillimetre);
  Trial trial(run, Box(sides, 512), {Floor()});
  const double touch = 0.5 * sides.y();
  trial.Start({Vec3(0, touch + kMillimetre, 0), Quat::Identity()});
  constexpr int kDown = 200;
  Wrench last;
  for (int i = 0; run.Goes(); ++i) {
    const double down = std::min(1.0, static_cast<double>(i) / kDown);
    // To and fro over 20 mm at the speed, along a line that is no edge of the mesh.
    const double way = speed * kMillimetre * std::max(0, i - kDown);
    const double to_and_fro = 10 * kMillimetre * std::sin(way / (10 * kMillimetre));
    const Vec3 at(0.8 * to_and_fro, touch + kMillimetre * (1.0 - 2.0 * down), 0.6 * to_and_fro);
    const Wrench wrench = trial.StepTo(at).wrench;
    if (i > kDown + 50) {
      run.Worst(wrench.torque.norm());
      // Chatter: 1 % of the force from one step to the next.
      run.tunnelled += (wrench.force - last.force).norm() > 0.01;
    }
    last = wrench;
  }
}

/// A ball slides over a smooth ball at 0.1 m/s and 1 N.  The true force turns by v dt / R, 0.0025 N
/// a step; 0.02 N is what the goal allows for the facets.
void SmoothSlide(CaseRun& run) {
  constexpr double kRadius = 40 * kMillimetre, kTool = 5 * kMillimetre;
  Trial trial(run, Ball(kTool), {Ball(kRadius, 1024)});
  trial.ExpectFree(false);  // the facets lie inside the ball: there is no closed form
  Vec3 last = Vec3::Zero();
  trial.Start({Vec3(0, kRadius + kTool + kMillimetre, 0), Quat::Identity()});
  for (int i = 0; run.Goes(); ++i) {
    const double down = std::min(1.0, 0.005 * i);
    const double angle = 1e-4 / kRadius * std::max(0, i - 250);
    // A great circle that precesses, so that each round meets other triangles.
    const Quat tilt = RotationExp(Vec3(0, 0.07 * angle, 0));
    const double height = kRadius + kTool + kMillimetre * (1.0 - 2.0 * down);
    const Vec3 force =
        trial.StepTo(height * (tilt * Vec3(std::sin(angle), std::cos(angle), 0))).wrench.force;
    if (i > 250) run.Worst((force - last).norm());
    last = force;
  }
}

Features WithFriction(const CaseRun& run, FrictionModel friction) {
  Features features = run.features;
  features.friction = friction;
  return features;
}

/// A ball pressed at 1 N and dragged to within the friction cone holds for a minute of noise.  The
/// figure is how far it creeps.
void Stick(CaseRun& run) {
  Trial trial(run, Ball(5 * kMillimetre), {Floor()}, kStiffness,
              WithFriction(run, FrictionModel::kCoulomb),
              {.static_friction = 0.8, .dynamic_friction = 0.3});
  Random random(61);
  const Vec3 rest(0.4 * kMillimetre, 4 * kMillimetre, 0);  // 0.4 of the normal force
  trial.Start({Vec3(0, 6 * kMillimetre, 0), Quat::Identity()});
  for (int i = 0; i < 200; ++i) {
    trial.StepTo(Vec3(0, (6.0 - 0.01 * i) * kMillimetre, 0));
  }
  for (int i = 0; i < 200; ++i) {
    trial.StepTo(Vec3(0.002 * i * kMillimetre, 4 * kMillimetre, 0));
  }
  const Vec3 begin = trial.StepTo(rest).X_WG.p;
  while (run.Goes()) {
    const Vec3 at = trial.StepTo(rest + random.InCube(20e-6)).X_WG.p;
    run.Worst(1e6 * Vec3(at.x() - begin.x(), 0.0, at.z() - begin.z()).norm());
  }
}

/// |F_t| / |F_n| of a ball that slides steadily, against mu_d: relative error.
void SlidingRatio(CaseRun& run, FrictionModel friction) {
  constexpr double kDynamic = 0.3;
  Trial trial(run, Ball(5 * kMillimetre), {Floor()}, kStiffness, WithFriction(run, friction),
              {.static_friction = 0.8, .dynamic_friction = kDynamic});
  trial.Start({Vec3(-20 * kMillimetre, 6 * kMillimetre, 0), Quat::Identity()});
  for (int i = 0; run.Goes(); ++i) {
    const double down = std::min(1.0, 0.005 * i);
    // A circle at 50 mm/s: one direction never lasts, and no edge of the plate is met.
    const double a = 0.0025 * std::max(0, i - 250);
    const Vec3 at(-20 * std::cos(a), 6.0 - 2.0 * down, 20 * std::sin(a));
    const Vec3 force = trial.StepTo(kMillimetre * at).wrench.force;
    if (i < 1000) continue;  // broken away by then
    const double ratio = Vec3(force.x(), 0.0, force.z()).norm() / std::abs(force.y());
    run.Worst(std::abs(ratio / kDynamic - 1.0));
  }
}

}  // namespace

std::vector<StabilityCase> TouchCases() {
  std::vector<StabilityCase> cases;
  cases.push_back(
      {.name = "encoder-noise",
       .what = "greatest change of force, over stiffness times greatest move of the hand",
       .reason = "a projection never moves further than what it projects; 1 % for bumps",
       .bound = 1.01,
       .unit = "",
       .share = 1,
       .run = Noise});
  cases.push_back({.name = "no-drift",
                   .what = "place in a round trip against the same of the second round",
                   .reason = "without friction a pose is the hand's alone; 0.1 um is rounding",
                   .bound = 0.1,
                   .unit = "um",
                   .share = 4,
                   .least = 4000,
                   .run = Drift});
  for (const bool slides : {false, true}) {
    cases.push_back({.name = slides ? "flat-box-slides" : "flat-box-rests",
                     .what = "torque on the hand at 1 N",
                     .reason = "the force goes through the middle of the face: the true torque is "
                               "0, and 1e-3 N m is 1 mm off that",
                     .bound = 1e-3,
                     .unit = "N m",
                     .share = 0.5,
                     .run = [=](CaseRun& run) { RestFlat(run, slides ? 0.05 : 0.0); },
                     .applies = Smooth});
  }
  cases.push_back({.name = "smooth-slide",
                   .what = "change of force from step to step at 0.1 m/s and 1 N",
                   .reason = "2 % of the force: a third of what a hand can tell apart",
                   .bound = 0.02,
                   .unit = "N",
                   .share = 1,
                   .run = SmoothSlide,
                   .applies = Smooth});
  cases.push_back({.name = "stick-a-minute",
                   .what = "creep while sticking under noise of 20 um",
                   .reason = "what sticks does not move; 1 um is below what can be seen",
                   .bound = 1.0,
                   .unit = "um",
                   .share = 1,
                   .least = 61000,
                   .run = Stick,
                   .applies = [](const Features& f) {
                     return Surface(f) && f.friction == FrictionModel::kCoulomb;
                   }});
  for (const FrictionModel friction : {FrictionModel::kCoulomb, FrictionModel::kChapter}) {
    const bool coulomb = friction == FrictionModel::kCoulomb;
    cases.push_back(
        {.name = coulomb ? "sliding-ratio-coulomb" : "sliding-ratio-chapter",
         .what = "|F_t| / |F_n| of steady sliding against mu_d, relative",
         .reason = coulomb ? "Coulomb's law; 1 % is far below what a hand notices"
                           : "the chapter's rule is no law: 8 % is the JND",
         .bound = coulomb ? 0.01 : 0.08,
         .unit = "",
         .share = 0.5,
         .least = 3000,
         .run = [=](CaseRun& run) { SlidingRatio(run, friction); },
         .applies = [=](const Features& f) { return Surface(f) && f.friction == friction; }});
  }
  return cases;
}

}  // namespace palpate::bench
