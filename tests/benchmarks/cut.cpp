// palpate-bench cut: a ball bur's volume, force, work and time in a block against exact values.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include <spdlog/fmt/fmt.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "server/physics/cut/cut_rows.h"
#include "server/physics/energy/energy_solver.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/cut_fit.h"
#include "tests/benchmarks/cut_scene.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/machine.h"
#include "tests/support/cut_of_rows.h"
#include "tests/support/volume_left.h"

namespace palpate::bench {
namespace {

struct Options : CutSceneOptions {
  std::string fit;
  std::vector<std::size_t> grids_um{100, 50, 25};
};

constexpr double kPi = 3.14159265358979323846;
constexpr double kRadius = 0.25e-3, kStiffness = 1000.0;
constexpr double kPlungeSpeed = 2e-3, kGrooveSpeed = 3e-3, kGroove = 0.8e-3;
/// The material's constants: 0.4 N on the whole front of the ball at zero speed, and a third more
/// at the speed of the plunge.
const Material kMaterial{.cutting_pressure = 2e6, .cutting_viscosity = 0.5e9};
/// Depth of the hand at the end of the plunge, where the bur's whole front is below the face, and
/// in the groove, where about half of the bur is.
constexpr double kPlungeDepth = 0.7e-3, kGrooveDepth = 0.42e-3;
/// An older groove of the same bur beside the path: its distance, and its axis's depth.
constexpr double kBeside = 0.3e-3, kOldDepth = 0.05e-3;
constexpr std::size_t kMostBytes = 1u << 30;

/// The block's frame P has its face in z = 0.
struct Direction {
  const char* name;
  Quat q_BP;
};
const Direction kAlong{"along the grid", Quat::Identity()};
const Direction kTurned{"turned by 30 deg", RotationExp(Vec3(0, 0, kPi / 6))};
const Direction kTilted{"tilted by 20 deg", RotationExp(Vec3(0, kPi / 9, 0))};
const Direction kBoth{"turned, tilted by 35 deg", RotationExp(Vec3(0, 35.0 / 180.0 * kPi, 0)) *
                                                      RotationExp(Vec3(0, 0, kPi / 6))};

struct Case {
  double spacing = 50e-6;
  int samples = 256;
  int rate = 1000;  ///< Hz
  Direction direction = kAlong;
  bool beside = false;  ///< an older groove
};

SolidGrid BlockOf(const Case& c) {
  TriangleMesh mesh = MakeBox(Vec3(2.4e-3, 1.6e-3, 0.8e-3));
  for (Vec3& v : mesh.vertices) v = c.direction.q_BP * (v - Vec3(0, 0, 0.4e-3));
  return SolidGrid(mesh, {.spacing = c.spacing, .most_bytes = kMostBytes}, "block");
}

double PlungeVolume(double depth) {
  return kPi * kRadius * kRadius * depth + 2.0 / 3.0 * kPi * std::pow(kRadius, 3);
}

/// Returns the volume below the face of a capsule whose axis lies `depth` below it.
double GrooveVolume(double depth) {
  const double r = kRadius, height = r + depth;
  return (0.5 * kPi * r * r + depth * std::sqrt(r * r - depth * depth) +
          r * r * std::asin(depth / r)) *
             kGroove +
         kPi * height * height * (3.0 * r - height) / 3.0;
}

double VolumeOf(const Case& c, CutField& cut, const Vec3& from_P, const Vec3& to_P) {
  const int steps = static_cast<int>(std::ceil((to_P - from_P).norm() / 3e-6));
  const Vec3 step = c.direction.q_BP * ((to_P - from_P) / steps);
  const double whole = test::TotalLeft(cut);
  for (int n = 0; n < steps; ++n) {
    const Pose X_BT{c.direction.q_BP * from_P + n * step, c.direction.q_BP};
    cut.Remove(Bur::Ball(kRadius), X_BT, step);
  }
  return whole - test::TotalLeft(cut);
}

/// Moves the bur along straight paths; returns the removed over the capsule's volume, minus 1.
Json MeasureVolume(const Case& c) {
  const SolidGrid block = BlockOf(c);
  Json json{{"spacing_um", 1e6 * c.spacing}, {"direction", c.direction.name}};
  CutField hole(block, kMostBytes, "block");
  const double plunge =
      VolumeOf(c, hole, Vec3(0, 0, kRadius), Vec3(0, 0, -0.2e-3)) / PlungeVolume(0.2e-3) - 1.0;
  json["plunge_error"] = plunge;
  std::string line =
      fmt::format("{:>5.0f} {:<26} {:>8.3f}", 1e6 * c.spacing, c.direction.name, 100.0 * plunge);
  auto grooves = Json::array();
  for (const double depth : {-0.15e-3, -0.05e-3, 0.0, 0.1e-3}) {
    CutField cut(block, kMostBytes, "block");
    const Vec3 from(-0.5 * kGroove, 0, -depth);
    const double error =
        VolumeOf(c, cut, from, from + Vec3(kGroove, 0, 0)) / GrooveVolume(depth) - 1.0;
    grooves.push_back({{"axis_below_face_m", depth}, {"error", error}});
    line += fmt::format(" {:>8.3f}", 100.0 * error);
  }
  json["grooves"] = grooves;
  fmt::print(stderr, "{}\n", line);
  return json;
}

/// Returns the law's force on the bur by a fine quadrature over the ball's front below the face:
/// exact except for the path's curvature.
Vec3 ExactForce(const Case& c, const std::vector<BurSample>& fine, const Vec3& p_P,
                const Vec3& velocity_P) {
  Vec3 sum = Vec3::Zero();
  for (const BurSample& s : fine) {
    const double speed = s.normal.dot(velocity_P);
    const Vec3 p = p_P + s.point;
    if (speed <= 0.0 || p.z() >= 0.0) continue;
    if (c.beside && std::hypot(p.y() - kBeside, p.z() + kOldDepth) < kRadius) continue;
    sum -= s.area * (kMaterial.cutting_pressure + kMaterial.cutting_viscosity * speed) * s.normal;
  }
  return sum;
}

/// A part of the path with a steady feed.
struct Steady {
  double change = 0.0;  ///< greatest of the force in a millisecond [N]
  double error = 0.0, force = 0.0;
  int steps = 0;
  std::optional<Vec3> last;

  void Add(const Vec3& force_P, const Vec3& exact_P, bool on_millisecond) {
    if (on_millisecond) {
      if (last) change = std::max(change, (force_P - *last).norm());
      last = force_P;
    }
    error += (force_P - exact_P).norm();
    force += force_P.norm();
    ++steps;
  }
  double mean_force() const { return force / steps; }
  double relative_error() const { return error / force; }
  Json ToJson() const {
    return {{"force_N", mean_force()}, {"force_error", relative_error()}, {"change_N_max", change}};
  }
};

/// The results of a hand's path, with the times of several runs.
struct Way {
  Steady plunge, groove;
  double rows_volume = 0.0, removed = 0.0, work = 0.0, law_work = 0.0, least_work = 0.0;
  int unsolved = 0;
  std::vector<double> turns;
};
struct Times {
  BestOf rows, solve, remove, step;
};

/// Simulates a hand, with the bur on the coupling's spring: it plunges, rises and cuts a groove.
Way GoTheWay(const Case& c, const SolidGrid& block, Times& times) {
  CutField cut(block, kMostBytes, "block");
  if (c.beside) {
    const Vec3 from(-0.9e-3, kBeside, -kOldDepth);
    VolumeOf(c, cut, from, from + Vec3(1.8e-3, 0, 0));
  }
  const Bur bur = Bur::Ball(kRadius);
  const std::vector<BurSample> samples = bur.Samples(c.samples), fine = bur.Samples(20000);
  std::array<Material, SolidGrid::kMaterials> materials;
  materials.fill(kMaterial);
  CutRows rows(c.samples);
  EnergySolver solver(16, static_cast<std::size_t>(c.samples));
  Energy* const energy = &rows;
  const Pose X_PB{Vec3::Zero(), c.direction.q_BP.conjugate()};  // P is the world
  const double dt = 1.0 / c.rate;
  Vec3 hand(-0.6e-3, 0, kRadius + 10e-6), bur_at = hand;
  double x[6] = {};
  Way way;
  std::vector<double> us[4];
  const int rise = static_cast<int>(0.05 / dt);
  const double feed_end = 0.6e-3;
  bool down = true;
  const double whole = test::TotalLeft(cut);
  for (int count = 0, risen = 0; hand.x() < feed_end; ++count) {
    const bool rising = !down && risen < rise;
    if (down) {
      hand.z() -= kPlungeSpeed * dt;
      down = hand.z() > -kPlungeDepth;
    } else if (rising) {
      hand.z() += (kPlungeDepth - kGrooveDepth) / rise;
      ++risen;
    } else {
      hand.x() += kGrooveSpeed * dt;
    }
    const Vec3 t = hand - bur_at;
    const double target[6] = {t.x(), t.y(), t.z()};  // a ball's rows do not turn it
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    rows.Clear();
    rows.AddSolid({samples, {bur_at, Quat::Identity()}, bur_at, kStiffness, 1.0, dt}, cut, X_PB,
                  materials);
    const auto built = Clock::now();
    const QpResult step = solver.Solve(ActiveKernels(), target, {}, {&energy, 1}, x, {});
    const auto solved = Clock::now();
    std::copy(step.x, step.x + 6, x);
    const Vec3 v(x[0], x[1], x[2]);
    cut.Remove(bur, {c.direction.q_BP * bur_at, c.direction.q_BP}, c.direction.q_BP * v);
    const auto end = Clock::now();
    int place = 0;
    for (const auto& took : {built - begin, solved - built, end - solved, end - begin}) {
      us[place++].push_back(std::chrono::duration<double, std::micro>(took).count());
    }
    way.turns.push_back(step.iterations);
    way.unsolved += step.status != QpStatus::kSolved;
    bur_at += v;
    const test::CutOfRows said(rows, x);
    way.rows_volume += said.volume;
    if (rising) continue;  // moves through space that it has cleared
    const Vec3 force = kStiffness * (v - t), exact = ExactForce(c, fine, bur_at, v / dt);
    way.work += kStiffness * said.work;
    way.least_work = std::min(way.least_work, kStiffness * said.work);
    way.law_work -= exact.dot(v);
    const bool on_millisecond = count % (c.rate / 1000) == 0;
    // The whole front is below the face; in the groove, the bur has also moved by its width.
    if (down && bur_at.z() < 0.0) way.plunge.Add(force, exact, on_millisecond);
    if (!down && hand.x() > 0.4e-3) way.groove.Add(force, exact, on_millisecond);
  }
  way.removed = whole - test::TotalLeft(cut);
  times.rows.Add(us[0]);
  times.solve.Add(us[1]);
  times.remove.Add(us[2]);
  times.step.Add(us[3]);
  return way;
}

Json MeasureForce(const Case& c, int repeats) {
  const SolidGrid block = BlockOf(c);
  Times times;
  Way way;
  for (int r = 0; r < repeats; ++r) way = GoTheWay(c, block, times);
  const Percentiles step = PercentilesOf(times.step.best()), turns = PercentilesOf(way.turns);
  const double volume_error = way.rows_volume / way.removed - 1.0;
  const double work_error = way.work / way.law_work - 1.0;
  fmt::print(stderr,
             "{:>5.0f} {:>5} {:>4.0f} {:<26} {:>7.4f} {:>6.2f} {:>7.4f} {:>7.4f} {:>6.2f} {:>7.4f} "
             "{:>7.2f} {:>7.2f} {:>5.0f} {:>6.0f} {:>6.0f}\n",
             1e6 * c.spacing, c.samples, 1e-3 * c.rate,
             c.beside ? "beside an older groove" : c.direction.name, way.plunge.mean_force(),
             100.0 * way.plunge.relative_error(), way.plunge.change, way.groove.mean_force(),
             100.0 * way.groove.relative_error(), way.groove.change, 100.0 * volume_error,
             100.0 * work_error, turns.max, step.p50, step.p999);
  return {{"spacing_um", 1e6 * c.spacing},
          {"samples", c.samples},
          {"rate_Hz", c.rate},
          {"direction", c.direction.name},
          {"beside_an_older_groove", c.beside},
          {"plunge", way.plunge.ToJson()},
          {"groove", way.groove.ToJson()},
          {"removed_mm3", 1e9 * way.removed},
          {"rows_volume_error", volume_error},
          {"work_J", way.work},
          {"work_error", work_error},
          {"least_work_of_a_step_J", way.least_work},
          {"unsolved", way.unsolved},
          {"turns", ToJson(turns)},
          {"best_rows_us", ToJson(PercentilesOf(times.rows.best()))},
          {"best_solve_us", ToJson(PercentilesOf(times.solve.best()))},
          {"best_remove_us", ToJson(PercentilesOf(times.remove.best()))},
          {"best_step_us", ToJson(step)},
          {"raw_step_us", ToJson(PercentilesOf(times.step.all()))}};
}

/// Measures the time of removal alone, for a ball (length 0) or a straight fissure bur that mills
/// sideways, at a depth of three quarters of a block.
Json MeasureRemoval(double spacing, double radius, double length, int repeats) {
  TriangleMesh mesh = MakeBox(Vec3(4e-3, 4e-3, 3e-3));
  const SolidGrid block(mesh, {.spacing = spacing, .most_bytes = kMostBytes}, "block");
  const Bur bur = length > 0.0 ? Bur::Cylinder(radius, length, 0.1e-3) : Bur::Ball(radius);
  const Vec3 step(3e-6, 0, 0);
  BestOf times;
  for (int r = 0; r < repeats; ++r) {
    CutField cut(block, kMostBytes, "block");
    Vec3 p(-0.5e-3, 0, 1.5e-3);
    for (; p.z() > -0.75e-3; p.z() -= 15e-6) {
      cut.Remove(bur, {p, Quat::Identity()}, Vec3(0, 0, -15e-6));
    }
    std::vector<double> us;
    for (int n = 0; n < 300; ++n, p += step) {
      const auto begin = std::chrono::steady_clock::now();
      cut.Remove(bur, {p, Quat::Identity()}, step);
      us.push_back(
          std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin)
              .count());
    }
    times.Add(us);
  }
  const Percentiles best = PercentilesOf(times.best());
  fmt::print(stderr, "{:>5.0f} {:>5.1f} x {:<4.1f} {:>8.0f} {:>8.0f}\n", 1e6 * spacing,
             2e3 * radius, 1e3 * length, best.p50, best.p999);
  return {{"spacing_um", 1e6 * spacing},
          {"diameter_m", 2.0 * radius},
          {"length_m", length},
          {"best_remove_us", ToJson(best)}};
}

void Run(const Options& options) {
  if (!options.fit.empty()) return RunCutFit(options.fit, options.json);
  if (!options.scene.empty()) return RunCutScene(options);
  auto volumes = Json::array(), forces = Json::array();
  fmt::print(stderr,
             "removed volume over the capsule's, less 1 [%]: plunge, and grooves whose axis lies "
             "below the face by\n{:>5} {:<26} {:>8} {:>8} {:>8} {:>8} {:>8}\n",
             "grid", "direction", "plunge", "-0.15mm", "-0.05mm", "0 mm", "0.1 mm");
  for (const std::size_t um : options.grids_um) {
    const double spacing = 1e-6 * static_cast<double>(um);
    for (const Direction& direction : {kAlong, kTurned, kTilted, kBoth}) {
      volumes.push_back(MeasureVolume({.spacing = spacing, .direction = direction}));
    }
  }
  fmt::print(stderr,
             "\nforce [N], its error [%] and greatest change in 1 ms [N] in plunge and groove; "
             "rows' volume and work, errors [%]; turns, most; step [us]\n"
             "{:>5} {:>5} {:>4} {:<26} {:>7} {:>6} {:>7} {:>7} {:>6} {:>7} {:>7} {:>7} {:>5} {:>6} "
             "{:>6}\n",
             "grid", "sampl", "kHz", "direction", "plunge", "error", "change", "groove", "error",
             "change", "volume", "work", "turns", "p50", "p99.9");
  std::vector<Case> cases;
  for (const std::size_t um : options.grids_um)
    cases.push_back({.spacing = 1e-6 * static_cast<double>(um)});
  for (const std::size_t um : options.grids_um)
    cases.push_back({.spacing = 1e-6 * static_cast<double>(um), .beside = true});
  // The other cases use a single grid: 50 um if that is among them.
  const bool usual = std::count(options.grids_um.begin(), options.grids_um.end(), 50) > 0;
  const double spacing = usual ? 50e-6 : 1e-6 * static_cast<double>(options.grids_um.front());
  cases.push_back({.spacing = spacing, .samples = 1024, .beside = true});
  for (const Direction& d : {kTurned, kTilted, kBoth}) {
    cases.push_back({.spacing = spacing, .direction = d});
  }
  for (const int samples : {64, 128, 512, 1024}) {
    cases.push_back({.spacing = spacing, .samples = samples});
  }
  for (const int samples : {256, 1024}) {
    cases.push_back({.spacing = spacing, .samples = samples, .rate = 4000});
  }
  for (const Case& c : cases) forces.push_back(MeasureForce(c, options.repeats));
  auto removals = Json::array();
  fmt::print(
      stderr,
      "\nremoval by greater burs [us]: grid, diameter x length [mm] (0: a ball), p50, p99.9\n");
  for (const std::size_t um : options.grids_um) {
    if (um < 50) continue;  // too slow for a millisecond
    for (const auto& [radius, length] : {std::pair{0.25e-3, 2e-3}, {0.6e-3, 4e-3}, {0.7e-3, 0.0}}) {
      removals.push_back(
          MeasureRemoval(1e-6 * static_cast<double>(um), radius, length, options.repeats));
    }
  }
  if (!options.json.empty()) {
    WriteJson(options.json, {{"machine", ToJson(ThisMachine())},
                             {"repeats", options.repeats},
                             {"bur_radius_m", kRadius},
                             {"stiffness_N_per_m", kStiffness},
                             {"pressure_Pa", kMaterial.cutting_pressure},
                             {"viscosity_Pa_s_per_m", kMaterial.cutting_viscosity},
                             {"volume", volumes},
                             {"force", forces},
                             {"removal", removals}});
  }
}

}  // namespace

void AddCut(const CommandLine& app) {
  auto options = std::make_shared<Options>();
  const CommandLine command = app.AddCommand(
      "cut",
      "error of removed volume, force and work of a bur, and time of a step\n"
      "Without --scene: a ball bur of 0.5 mm in a flat block.  Compares the volume with\n"
      "the exact sweep, and force and work with the cutting law; takes about half a\n"
      "minute.\n"
      "With --scene: step, force, volume, work, surface and ripple of that scene.\n"
      "With --fit: fits the cutting law to measured feeds and forces.");
  command.Footer(
      "Examples:\n"
      "  palpate-bench cut --json cut.json\n"
      "  palpate-bench cut --scene ./groove.json");
  const Option scene =
      Add(command, "--scene", options->scene, "scene with a bur, from the catalogue or a file");
  Add(command, "--poses", options->poses,
      "haptic poses (CSV: x,y,z,qw,qx,qy,qz, one row per millisecond); default: the scene's "
      "script, else a plunge and a groove")
      .Needs(scene);
  Add(command, "--surface", options->surface, "write the remaining solids to FILE.stl, in metres")
      .Needs(scene);
  Add(command, "--sweep", options->sweep,
      "write the solids and the path of the bur to FILE.json, from which another program can "
      "compute "
      "the removed volume")
      .Needs(scene);
  Add(command, "--burs", options->burs,
      "cut the scene's block with each of these burs instead: ISO 6360 numbers such as "
      "001/014,237/014")
      .Needs(scene);
  Add(command, "--fit", options->fit,
      "fit the cutting law to FILE.csv, with rows material,area_mm2,share,feed_mm_per_s,force_N: "
      "area of the cutting front across the feed, its share of viscosity (flat 1, ball 0.667), "
      "and the measured feed and force")
      .Excludes(scene);
  Add(command, "--grid-um", options->grids_um, "spacings of the grid in um, 25 to 200")
      .Excludes(scene);
  AddRepeats(command, options->repeats);
  AddJson(command, options->json);
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
