#include "tests/benchmarks/cut_scene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "common/math/rotation.h"
#include "scenes/catalogue.h"
#include "scenes/grid/bur_sweep.h"
#include "scenes/grid/solid_surface.h"
#include "scenes/shapes/shape_kinds.h"
#include "server/physics/haptic_step.h"
#include "server/physics/scene_model.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/pose_source.h"
#include "tests/support/volume_left.h"
#include "tests/support/written_mesh.h"

namespace palpate::bench {
namespace {

constexpr double kPlungeSpeed = 2e-3, kFeed = 3e-3, kPeriod = 1e-3;

/// The results of a hand's run over the scene.
struct Cut {
  std::vector<double> us;
  std::vector<Vec3> force;
  std::vector<Pose> X_WG;  ///< of the tool, the start's first
  double volume = 0.0, work = 0.0, jump = 0.0;
  int unsolved = 0;
  StepState state;
};

Cut Run(const HapticModel& model, const std::vector<Pose>& hand, int repeats) {
  BestOf times;
  Cut cut;
  const auto left = [](const StepState& state) {
    double sum = 0.0;
    for (const CutField& field : state.cut.fields) sum += test::TotalLeft(field);
    return sum;
  };
  for (int r = 0; r < repeats; ++r) {
    cut = Cut{};
    cut.state = StepState(model);
    StepWorkspace workspace(model);
    cut.state.X_WG = cut.state.X_WH = hand.front();
    cut.X_WG.push_back(hand.front());
    const double whole = left(cut.state);
    std::vector<double> us;
    for (const Pose& X_WH : hand) {
      const auto begin = std::chrono::steady_clock::now();
      const StepReport report = HapticStep(model, X_WH, cut.state, workspace);
      us.push_back(
          std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin)
              .count());
      const Pose& X = cut.X_WG.back();
      const Vec3 v = report.X_WG * model.reference() - X * model.reference();
      const Vec3 phi = RotationLog(report.X_WG.q * X.q.conjugate());
      cut.work -= report.wrench.force.dot(v) + report.wrench.torque.dot(phi);
      cut.unsolved += (report.faults & kFaultUnsolved) != 0;
      if (!cut.force.empty()) {
        cut.jump = std::max(cut.jump, (report.wrench.force - cut.force.back()).norm());
      }
      cut.force.push_back(report.wrench.force);
      cut.X_WG.push_back(report.X_WG);
    }
    times.Add(us);
    cut.volume = whole - left(cut.state);
  }
  cut.us = times.best();
  return cut;
}

/// Makes a path down into the middle of the left part of the first solid's top, by a depth or by
/// two thirds of the bur's width, and then to the right, over half of the solid's width.
std::vector<Pose> UsualHand(const Scene& scene, std::optional<double> depth = std::nullopt) {
  const Body& solid =
      *std::ranges::find_if(scene.objects, [](const Body& b) { return b.grid.has_value(); });
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const Vec3& v : solid.mesh.vertices) {
    low = low.cwiseMin(solid.X_WB * v);
    high = high.cwiseMax(solid.X_WB * v);
  }
  double width = 0.0;
  const BurProfile& bur = *scene.tools.front().bur;
  for (const auto& point : bur.curve) width = std::max(width, point[0] + bur.rounding);
  Vec3 at(low.x() + 0.25 * (high - low).x(), high.y() + 0.05e-3, 0.5 * (low + high).z());
  std::vector<Pose> hand;
  const double bottom = high.y() - depth.value_or(4.0 / 3.0 * width),
               end = at.x() + 0.5 * (high - low).x();
  for (; at.y() > bottom; at.y() -= kPlungeSpeed * kPeriod) hand.push_back({at});
  for (; at.x() < end; at.x() += kFeed * kPeriod) hand.push_back({at});
  return hand;
}

/// A straight segment of the bur's path in a solid's frame, and a bounding box of its sweep.
struct Piece {
  Pose X_TB;
  Vec3 step_T;
  Vec3 low, high;
};
/// Splits a path into segments of at least `shortest`.
std::vector<Piece> WayOf(const HapticModel& model, const Cut& cut, const CutSolid& solid,
                         double shortest) {
  const Pose X_BW = solid.X_WB.Inverse();
  const Bur& bur = model.cutting()->bur;
  std::vector<Piece> way;
  const auto at = [&](std::size_t i) { return X_BW * cut.X_WG[i] * model.cutting()->X_TB; };
  Pose from = at(0);
  for (std::size_t i = 1; i < cut.X_WG.size(); ++i) {
    const Pose to = at(i);
    if ((to.p - from.p).norm() < shortest && i + 1 < cut.X_WG.size()) continue;
    const Vec3 a = from * Vec3(0, 0, bur.low() + bur.radius());
    const Vec3 b = from * Vec3(0, 0, bur.high() - bur.radius());
    const Vec3 step = to.p - from.p, zero = Vec3::Zero(), r = Vec3::Constant(bur.radius());
    way.push_back({from.Inverse(), from.q.conjugate() * step,
                   a.cwiseMin(b).cwiseMin(from.p) + step.cwiseMin(zero) - r,
                   a.cwiseMax(b).cwiseMax(from.p) + step.cwiseMax(zero) + r});
    from = to;
  }
  return way;
}

/// Returns a pseudo-random point in the unit cube for a number (splitmix64).
Vec3 Within(std::uint64_t number) {
  Vec3 place;
  for (int c = 0; c < 3; ++c) {
    std::uint64_t z = (3 * number + static_cast<std::uint64_t>(c) + 1) * 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    place[c] = static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }
  return place;
}

/// Estimates the volume of the exact sweep within a solid by counting points: one random point in
/// each cell of a lattice, so that no face is aligned with them.
struct Swept {
  double volume = 0.0;
  double price = 0.0;  ///< sum of p_0 over the volume [J]
};
Swept SweptOf(const HapticModel& model, const Cut& cut, const CutSolid& solid) {
  const double fine = solid.grid->field().lattice().spacing / 2.3;
  const std::vector<Piece> way = WayOf(model, cut, solid, 2.0 * fine);
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const Piece& piece : way) {
    low = low.cwiseMin(piece.low);
    high = high.cwiseMax(piece.high);
  }
  const auto size = ((high - low) / fine).array().ceil().cast<long>().eval();
  // How far the bur has to go before it can reach each point: a point of the bur goes no farther
  // than its frame's origin, and its turn times its greatest distance from there.
  std::vector<float> not_before(static_cast<std::size_t>(size.prod()), 0.0f);
  const Bur& bur = model.cutting()->bur;
  constexpr double kRounding = 1e-7;  // of a distance in floats, and of a sum of them [m]
  double gone = 0.0;
  Swept swept;
  for (std::size_t n = 0; n < way.size(); ++n) {
    const Piece& piece = way[n];
    const BurSweep sweep(bur, piece.step_T);
    const double length = piece.step_T.norm();
    const Vec3 from = (piece.low - low) / fine, to = (piece.high - low) / fine;
    const auto end = [&](int c) { return std::min(size[c], static_cast<long>(to[c]) + 1); };
    for (long k = static_cast<long>(from.z()); k < end(2); ++k) {
      for (long j = static_cast<long>(from.y()); j < end(1); ++j) {
        for (long i = static_cast<long>(from.x()); i < end(0); ++i) {
          const auto at = static_cast<std::size_t>((k * size.y() + j) * size.x() + i);
          if (not_before[at] > gone + length) continue;
          const Vec3 p = low + fine * (Vec3(double(i), double(j), double(k)) + Within(at));
          const double distance = sweep.Distance(piece.X_TB * p);
          if (!(distance < 0.0)) {
            // BurSweep::Distances may be too large by a twentieth of the step.
            not_before[at] = static_cast<float>(gone + distance - 0.05 * length - kRounding);
            continue;
          }
          not_before[at] = std::numeric_limits<float>::infinity();
          if (!(solid.grid->Sample(p).distance < 0.0)) continue;
          const double cell = fine * fine * fine;
          swept.volume += cell;
          swept.price += cell * solid.materials[solid.grid->Material(p)].cutting_pressure;
        }
      }
    }
    gone += length;
    if (n + 1 < way.size()) gone += bur.reach() * piece.X_TB.q.angularDistance(way[n + 1].X_TB.q);
  }
  return swept;
}

/// Measures the distance between the remaining surface and the exact sweep, for surface made by a
/// cut, at its crossings with the lattice [m].
std::vector<double> SurfaceErrors(const HapticModel& model, const Cut& cut, std::size_t number) {
  const CutSolid& solid = model.solids()[number];
  const CutField& field = cut.state.cut.fields[number];
  const Lattice& lattice = field.field().lattice();
  const double h = lattice.spacing;
  const std::vector<Piece> way = WayOf(model, cut, solid, 0.3 * h);
  std::vector<double> errors;
  const auto sweep = [&](const Vec3& p) {
    double least = 1e300;
    for (const Piece& piece : way) {
      const Vec3 margin = Vec3::Constant(2.0 * h);
      if ((p.array() < (piece.low - margin).array()).any()) continue;
      if ((p.array() > (piece.high + margin).array()).any()) continue;
      least =
          std::min(least, BurSweep(model.cutting()->bur, piece.step_T).Distance(piece.X_TB * p));
    }
    return least;
  };
  const auto sides = lattice.blocks;
  for (int k = 0; k < 8 * sides[2]; ++k) {
    for (int j = 0; j < 8 * sides[1]; ++j) {
      for (int i = 0; i + 1 < 8 * sides[0]; ++i) {
        const double a = field.field().At(i, j, k), b = field.field().At(i + 1, j, k);
        if ((a < 0.0) == (b < 0.0)) continue;
        const Vec3 p = lattice.Point(i, j, k) + Vec3(h * a / (a - b), 0.0, 0.0);
        // If the old surface is nearer, this part was not made by the cut.
        if (solid.grid->Sample(p).distance > -h) continue;
        errors.push_back(std::abs(sweep(p)));
      }
    }
  }
  return errors;
}

/// Makes the same solids in grids that are rotated by 30 degrees in the world's plane y = 0; none
/// if a box assigns materials.
std::optional<Scene> Turned(Scene scene) {
  const Quat turn(Eigen::AngleAxisd(M_PI / 6.0, Vec3::UnitY()));
  for (Body& body : scene.objects) {
    if (!body.grid) continue;
    for (const MaterialRegion& region : body.grid->regions) {
      if (!(region.radius > 0.0) && region.mesh.triangles.empty()) return std::nullopt;
    }
    const Quat of_body = body.X_WB.q.conjugate() * turn * body.X_WB.q;
    for (Vec3& v : body.mesh.vertices) v = of_body.conjugate() * v;
    for (MaterialRegion& region : body.grid->regions) {
      region.low = of_body.conjugate() * region.low;
      for (Vec3& v : region.mesh.vertices) v = of_body.conjugate() * v;
    }
    body.X_WB.q = body.X_WB.q * of_body;
  }
  return scene;
}

/// Writes the remaining solids, in W, as a binary STL.
void WriteSurface(const HapticModel& model, const Cut& cut, const std::string& file) {
  TriangleMesh left;
  for (std::size_t i = 0; i < model.solids().size(); ++i) {
    const SolidSurface surface = WholeSurface(cut.state.cut.fields[i]);
    const auto first = static_cast<std::uint32_t>(left.vertices.size());
    for (const Vec3& v : surface.vertices) left.vertices.push_back(model.solids()[i].X_WB * v);
    for (const auto& [a, b, c] : surface.triangles) {
      left.triangles.push_back({first + a, first + b, first + c});
    }
  }
  std::ofstream out(file, std::ios::binary);
  out << test::BinaryStlOf(left);
  if (!out.flush())
    throw Error(file + ": cannot be written; give a file in a folder that takes one");
}

/// Runs a scene's first tool along a hand's path.
struct Figures {
  Percentiles us;
  double volume = 0.0, volume_error = 0.0, work_error = 0.0, jump = 0.0;
  double surface_rms = 0.0, surface_most = 0.0;  ///< [m]
  std::size_t places = 0;                        ///< that the surface was measured at
  std::optional<double> ripple = {};             ///< none: a box paints a material along the grid
  int unsolved = 0;
};

void AddSurface(const std::vector<double>& errors, Figures& figures) {
  double squares = 0.0;
  for (const double e : errors) {
    squares += e * e;
    figures.surface_most = std::max(figures.surface_most, e);
  }
  figures.places = errors.size();
  if (!errors.empty()) figures.surface_rms = std::sqrt(squares / double(errors.size()));
}

/// Without viscosity the work is pressure times removed volume; returns the ratio minus 1.
double WorkErrorOf(const Scene& scene, const std::vector<Pose>& hand) {
  Scene plastic = scene;
  for (Body& body : plastic.objects) {
    for (Material& material : body.materials) material.cutting_viscosity = 0.0;
  }
  const HapticModel model = MakeModel(plastic, plastic.tools.front(), MakeObjects(plastic));
  const Cut plain = Run(model, hand, 1);
  double price = 0.0;
  for (const CutSolid& solid : model.solids()) price += SweptOf(model, plain, solid).price;
  return plain.work / price - 1.0;
}

std::optional<double> RippleOf(const Scene& scene, const std::vector<Pose>& hand, const Cut& cut) {
  const std::optional<Scene> turned = Turned(scene);
  if (!turned) return std::nullopt;
  const HapticModel model = MakeModel(*turned, turned->tools.front(), MakeObjects(*turned));
  const Cut beside = Run(model, hand, 1);
  double difference = 0.0, force = 0.0;
  for (std::size_t i = 0; i < hand.size(); ++i) {
    difference += (beside.force[i] - cut.force[i]).norm();
    force += cut.force[i].norm();
  }
  return difference / force;
}

Figures Measure(const Scene& scene, const std::vector<Pose>& hand, const CutSceneOptions& options) {
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  Progress("the hand");
  const Cut cut = Run(model, hand, options.repeats);
  if (!options.surface.empty()) WriteSurface(model, cut, options.surface);
  Figures figures{.us = PercentilesOf(cut.us), .volume = cut.volume, .jump = cut.jump};
  figures.unsolved = cut.unsolved;
  Progress("the exact sweep");
  double swept = 0.0;
  std::vector<double> surface;
  for (std::size_t i = 0; i < model.solids().size(); ++i) {
    swept += SweptOf(model, cut, model.solids()[i]).volume;
    const std::vector<double> errors = SurfaceErrors(model, cut, i);
    surface.insert(surface.end(), errors.begin(), errors.end());
  }
  figures.volume_error = cut.volume / swept - 1.0;
  AddSurface(surface, figures);
  Progress("the work");
  figures.work_error = WorkErrorOf(scene, hand);
  Progress("the turned grid");
  figures.ripple = RippleOf(scene, hand, cut);
  Progress("");
  return figures;
}

Json ToJson(const Figures& f) {
  return {{"step_us", ToJson(f.us)},
          {"force_jump_N_max", f.jump},
          {"cut_m3", f.volume},
          {"volume_error", f.volume_error},
          {"work_error", f.work_error},
          {"surface_um", {{"rms", 1e6 * f.surface_rms}, {"max", 1e6 * f.surface_most}}},
          {"ripple", f.ripple ? Json(*f.ripple) : Json()},
          {"unsolved", f.unsolved}};
}

/// Makes a path down into a solid by half of the bur's head, at most 2.5 mm, and to the right.
std::vector<Pose> MillingHand(const Scene& scene) {
  const BurProfile& profile = *scene.tools.front().bur;
  const Bur bur(profile.curve, profile.rounding);
  return UsualHand(scene, std::min(0.5 * (bur.high() - bur.low()), 2.5e-3));
}

/// Returns the scene with another bur in its first tool's handle.
Scene WithBur(Scene scene, const std::string& name) {
  const ShapeKind& kind = *FindShapeKind("bur");
  const ShapeChoice bur = BurNamed(name);
  scene.tools.front().mesh = kind.make(bur.variant, bur.values);
  scene.tools.front().bur = kind.bur(bur.variant, bur.values);
  return scene;
}

void RunBurs(const Scene& scene, const CutSceneOptions& options) {
  auto rows = Json::array();
  fmt::print(stderr,
             "burs, plunge and groove: cut [mm3], volume and work, errors [%]; surface [um] rms, "
             "most; change of force in 1 ms [N]; turned grid [%]; step [us]\n"
             "{:<8} {:>7} {:>7} {:>7} {:>6} {:>6} {:>7} {:>7} {:>6} {:>6} {:>8}\n",
             "bur", "cut", "volume", "work", "rms", "most", "change", "turned", "p50", "p99.9",
             "unsolved");
  for (const std::string& name : options.burs) {
    const Scene with = WithBur(scene, name);
    const Figures f = Measure(with, MillingHand(with), options);
    fmt::print(stderr,
               "{:<8} {:>7.3f} {:>7.2f} {:>7.2f} {:>6.1f} {:>6.1f} {:>7.4f} {:>7.3f} {:>6.0f} "
               "{:>6.0f} {:>8}\n",
               name, 1e9 * f.volume, 100.0 * f.volume_error, 100.0 * f.work_error,
               1e6 * f.surface_rms, 1e6 * f.surface_most, f.jump, 100.0 * f.ripple.value_or(0.0),
               f.us.p50, f.us.p999, f.unsolved);
    Json row = ToJson(f);
    row["bur"] = name;
    rows.push_back(row);
  }
  if (options.json.empty()) return;
  WriteJson(options.json,
            {{"machine", ToJson(ThisMachine())}, {"repeats", options.repeats}, {"burs", rows}});
}

}  // namespace

void RunCutScene(const CutSceneOptions& options) {
  const Scene scene = LoadScene(options.scene);
  if (!scene.tools.front().bur ||
      std::ranges::none_of(scene.objects, [](const Body& b) { return b.grid.has_value(); })) {
    throw Error(options.scene +
                ": nothing of it can be cut; give an object \"grid_um\" and the tool "
                "the shape \"bur\"");
  }
  if (!options.burs.empty()) return RunBurs(scene, options);
  const bool script = std::filesystem::exists(ScriptFileBeside(options.scene));
  const std::vector<Pose> hand = !options.poses.empty() ? ReadPoses(options.poses)
                                 : script               ? ScriptPoses(options.scene, std::nullopt)
                                                        : UsualHand(scene);
  const Figures f = Measure(scene, hand, options);
  Table table(fmt::format("{}: {} steps, {:.3f} mm3 cut", scene.name, hand.size(), 1e9 * f.volume));
  table.Row("step, best", "us", f.us);
  table.Line("greatest change of force", fmt::format("{:.4f} N in a millisecond", f.jump));
  table.Line("volume", fmt::format("{:+.2f} % of the exact sweep", 100.0 * f.volume_error));
  table.Line("work, kappa = 0",
             fmt::format("{:+.2f} % of p0 times the volume", 100.0 * f.work_error));
  table.Line("surface",
             fmt::format("{:.1f} um rms, {:.1f} um at most from the exact sweep, at {} places",
                         1e6 * f.surface_rms, 1e6 * f.surface_most, f.places));
  table.Line("grid turned by 30 deg",
             f.ripple ? fmt::format("force differs by {:.2f} %", 100.0 * *f.ripple)
                      : "not measured: a box paints a material along the grid");
  table.Line("unsolved", std::to_string(f.unsolved));
  table.Print();
  if (options.json.empty()) return;
  Json json = ToJson(f);
  json["machine"] = ToJson(ThisMachine());
  json["scene"] = scene.name;
  json["steps"] = hand.size();
  json["repeats"] = options.repeats;
  WriteJson(options.json, json);
}

}  // namespace palpate::bench
