// palpate-bench accuracy: force against analytic truth, the chapter's 2.5.1 (eq. 2.36,
// Figs. 2.16-2.18).
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "scenes/mesh_query.h"
#include "scenes/shapes.h"
#include "scenes/sphere_tree_builder.h"
#include "server/physics/simd/kernels.h"
#include "server/session/scene_model.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/features.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/sliding_path.h"
#include "tests/benchmarks/svg_plot.h"

namespace palpate::bench {
namespace {

struct Options {
  std::string object = "cube";
  std::vector<std::size_t> spheres{64, 512, 4096};
  std::size_t triangles = 20480;
  FeatureOverrides features{.contact = "surface", .friction = "off"};
  int steps = 4000;
  int repeats = 5;
  std::string json, plot;

  bool cube() const { return object == "cube"; }
};

/// "A polygonal mesh with over 4,000 triangles", which the chapter compares 64 spheres with.
constexpr std::size_t kComparedTriangles = 4001;

struct MeanMax {
  double mean = 0.0, max = 0.0;
  void Add(double value, std::size_t of) {
    mean += value / static_cast<double>(of);
    max = std::max(max, value);
  }
};
nlohmann::ordered_json ToJson(const MeanMax& m) {
  return {{"mean", m.mean}, {"max", m.max}};
}

/// Errors of the forces of a sliding path, (2.36): delta = (F_gm - F_tm) / |F_gm|, gm the truth.
struct ForceErrors {
  std::vector<double> x, y;    ///< delta of each steady sample, as the chapter plots it
  MeanMax axis[3], magnitude;  ///< |delta_x|, |delta_y|, |delta_z|; |delta|
  MeanMax strength;            ///< ||F_tm| - |F_gm|| / |F_gm|: what the JND of 6-8 % is about
  MeanMax direction_deg;

  ForceErrors(const SlidingPath& path, const std::vector<Vec3>& forces) {
    const std::size_t count = forces.size() - path.steady;
    for (std::size_t i = path.steady; i < forces.size(); ++i) {
      const Vec3 truth = kSlidingStiffness * kSlidingDepth * path.normal[i];
      const Vec3 delta = (truth - forces[i]) / truth.norm();
      x.push_back(delta.x());
      y.push_back(delta.y());
      for (int k = 0; k < 3; ++k) axis[k].Add(std::abs(delta[k]), count);
      magnitude.Add(delta.norm(), count);
      strength.Add(std::abs(forces[i].norm() / truth.norm() - 1.0), count);
      direction_deg.Add(
          180.0 / M_PI * std::atan2(truth.cross(forces[i]).norm(), truth.dot(forces[i])), count);
    }
  }

  void AddTo(nlohmann::ordered_json& json) const {
    json["force_error"] = {{"x", ToJson(axis[0])},
                           {"y", ToJson(axis[1])},
                           {"z", ToJson(axis[2])},
                           {"magnitude", ToJson(magnitude)},
                           {"strength", ToJson(strength)}};
    json["direction_deg"] = ToJson(direction_deg);
  }
  std::string Columns() const {
    return fmt::format("{:>8.5f} {:>8.5f}  {:>8.5f} {:>8.5f}  {:>7.3f} {:>7.3f}", magnitude.mean,
                       magnitude.max, strength.mean, strength.max, direction_deg.mean,
                       direction_deg.max);
  }
};

struct Measured {
  std::size_t spheres = 0, triangles = 0;
  ForceErrors errors;
  MeanMax truncation_um;
  BestOf step_us;
};

TriangleMesh ObjectMesh(const Options& options, std::size_t triangles) {
  return options.cube() ? MakeBox(Vec3::Constant(kCubeSide))
                        : MakeEllipsoid(kEllipsoidAxes, triangles);
}

SlidingPath PathOf(const Options& options) {
  return options.cube() ? SlideOverCube(options.steps) : SlideOverEllipsoid(options.steps);
}

Scene MakeScene(const Options& options, std::size_t spheres) {
  Scene scene;
  scene.name = "accuracy, " + options.object;
  scene.coupling.stiffness = kSlidingStiffness;
  Body ball, object;
  ball.mesh = MakeSphere(kSlidingBallRadius, 320);
  ball.tree = SingleSphereTree(ball.mesh, {Vec3::Zero(), kSlidingBallRadius});
  object.mesh = ObjectMesh(options, options.triangles);
  object.tree = BuildSphereTree(object.mesh, spheres, [&](std::string_view stage, double done) {
    Progress(fmt::format("{} of {} spheres: {} {:.0f} % ...", options.object, spheres, stage,
                         100.0 * done));
  });
  scene.tools.push_back(std::move(ball));
  scene.objects.push_back(std::move(object));
  options.features.Apply(scene);
  return scene;
}

/// What linearising the gap (2.10-2.17) left out in a step: the true gap of each active pair of
/// balls less the one that its row promised [m].
double Truncation(const StepReport& report, const SphereTree& object) {
  double worst = report.truncation;  // of the rotation, which a ball has none of
  for (int c = 0; c < report.contacts; ++c) {
    const ActiveRow& row = report.active[static_cast<std::size_t>(c)];
    const auto leaf = static_cast<std::size_t>(row.pair.object);
    const Vec3 centre(object.leaf_x[leaf], object.leaf_y[leaf], object.leaf_z[leaf]);
    const double gap =
        (report.X_WG.p - centre).norm() - (kSlidingBallRadius + object.leaf_radius[leaf]);
    worst = std::max(worst, std::abs(gap + row.offset));
  }
  return worst;
}

Measured Measure(const Options& options, const SlidingPath& path, std::size_t spheres) {
  const Scene scene = MakeScene(options, spheres);
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  StepWorkspace workspace(model);
  BestOf step_us;
  std::vector<Vec3> forces;
  MeanMax truncation_um;
  using Clock = std::chrono::steady_clock;
  for (int r = 0; r < options.repeats; ++r) {
    Progress(fmt::format("{} of {} spheres: repeat {} of {} ...", options.object, spheres, r + 1,
                         options.repeats));
    StepState state(model);
    state.X_WG.p = path.hand.front();
    std::vector<double> us;
    for (std::size_t i = 0; i < path.hand.size(); ++i) {
      const auto begin = Clock::now();
      const StepReport report =
          HapticStep(model, {path.hand[i], Quat::Identity()}, state, workspace);
      const auto end = Clock::now();
      if (i >= path.steady) {
        us.push_back(std::chrono::duration<double, std::micro>(end - begin).count());
      }
      if (r > 0) continue;
      forces.push_back(report.wrench.force);
      if (i >= path.steady) {
        truncation_um.Add(1e6 * (scene.features.contact == ContactModel::kSpheres
                                     ? Truncation(report, scene.objects.front().tree)
                                     : report.truncation),
                          path.hand.size() - path.steady);
      }
    }
    step_us.Add(us);
  }
  Progress("");
  return {spheres, scene.objects.front().mesh.triangles.size(), ForceErrors(path, forces),
          truncation_um, step_us};
}

/// The god-object on the mesh itself, flat triangles and all: the object is convex and the hand
/// outside it (the ball's radius is 5 mm, its depth 1 mm), so the contact is the mesh's nearest
/// point.
ForceErrors OnMesh(const SlidingPath& path, const TriangleMesh& mesh) {
  const MeshQuery query(mesh);
  std::vector<Vec3> forces;
  for (const Vec3& hand : path.hand) {
    const Vec3 apart = hand - query.Nearest(hand).point;
    const double depth = std::max(0.0, kSlidingBallRadius - apart.norm());
    forces.push_back(kSlidingStiffness * depth * apart.normalized());
  }
  return {path, forces};
}

nlohmann::ordered_json ToJson(const Measured& m) {
  nlohmann::ordered_json json{{"spheres", m.spheres}, {"triangles", m.triangles}};
  m.errors.AddTo(json);
  json["truncation_um"] = ToJson(m.truncation_um);
  json["best_step_us"] = ToJson(PercentilesOf(m.step_us.best()));
  return json;
}

/// As Figs. 2.17 and 2.18: the error of each component over time.
void WritePlot(const Options& options, const std::vector<Measured>& rows) {
  std::vector<Plot> plots;
  for (const char axis : {'x', 'y'}) {
    Plot plot{.title = fmt::format("Force error along {}: ball on the {}, {} contact", axis,
                                   options.object, options.features.contact),
              .x = {.title = "Time of steady sliding [ms]"},
              .y = {.title = "Error, of the true 1 N [-]"},
              .height = 240};
    if (axis == 'x') plot.subtitle = "δF of eq. 2.36 against the analytic object";
    for (const Measured& row : rows) {
      PlotSeries series{.name = fmt::format("{} spheres", row.spheres)};
      series.y = axis == 'x' ? row.errors.x : row.errors.y;
      for (std::size_t i = 0; i < series.y.size(); ++i) {
        series.x.push_back(static_cast<double>(i));
      }
      plot.series.push_back(std::move(series));
    }
    for (const double sign : {1.0, -1.0}) {
      plot.references.push_back({.value = 0.06 * sign, .text = "JND 6 %"});
    }
    plots.push_back(std::move(plot));
  }
  WriteSvg(options.plot, plots);
}

void Run(const Options& options) {
  const SlidingPath path = PathOf(options);
  std::vector<Measured> rows;
  for (const std::size_t spheres : options.spheres) rows.push_back(Measure(options, path, spheres));

  std::string table = fmt::format(
      "{}, {} contact: a ball of 5 mm slides at 1 N, {} samples, best of {} ({})\n"
      "  {:<22} {:^17}  {:^17}  {:^15}  {:>10} {:>10}\n"
      "  {:<22} {:>8} {:>8}  {:>8} {:>8}  {:>7} {:>7}  {:>10} {:>10}\n",
      options.object, options.features.contact, options.steps, options.repeats,
      ActiveKernels().name, "", "force error |dF|", "of the strength", "direction, deg",
      "truncation", "step p99.9", "spheres", "mean", "max", "mean", "max", "mean", "max", "max, um",
      "us");
  for (const Measured& row : rows) {
    table += fmt::format("  {:<22} {}  {:>10.4f} {:>10.2f}\n", row.spheres, row.errors.Columns(),
                         row.truncation_um.max, PercentilesOf(row.step_us.best()).p999);
  }
  nlohmann::ordered_json json{{"object", options.object},
                              {"contact", options.features.contact},
                              {"steps", options.steps},
                              {"repeats", options.repeats},
                              {"simd", ActiveKernels().name}};
  if (rows.size() == 1) {
    json.update(ToJson(rows.front()));
  } else {
    for (const Measured& row : rows) json["results"].push_back(ToJson(row));
  }
  if (!options.cube()) {
    const TriangleMesh mesh = ObjectMesh(options, kComparedTriangles);
    const ForceErrors on_mesh = OnMesh(path, mesh);
    table += fmt::format("  {:<22} {}\n", fmt::format("mesh, {} triangles", mesh.triangles.size()),
                         on_mesh.Columns());
    json["mesh"]["triangles"] = mesh.triangles.size();
    on_mesh.AddTo(json["mesh"]);
  }
  table += options.cube()
               ? "  chapter: mean about 0.05 at 4,096 spheres; truncation below 1 um\n"
               : "  chapter: max about 0.05 at 512 spheres; 64 spheres beat over 4,000 triangles; "
                 "truncation below 1 um\n";
  table += "  humans notice 6-8 % of a force's strength\n";
  std::fputs(table.c_str(), stderr);
  if (!options.json.empty()) WriteJson(options.json, json);
  if (!options.plot.empty()) WritePlot(options, rows);
}

}  // namespace

void AddAccuracy(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "accuracy",
      "Force of a ball that slides over a cube or an ellipsoid, against analytic truth\n"
      "(chapter 2.5.1): a ball of 5 mm, commanded 1 mm deep at 1 N/mm, translation only.\n"
      "Example: palpate-bench accuracy --object ellipsoid --spheres 8,64,512 --plot e.svg");
  command->add_option("--object", options->object, "cube (50 mm) or ellipsoid (40, 25, 30 mm)")
      ->check(CLI::IsMember({"cube", "ellipsoid"}))
      ->capture_default_str();
  command->add_option("--spheres", options->spheres, "Leaves of the object's tree; a row for each")
      ->delimiter(',')
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--triangles", options->triangles,
                   "Ellipsoid: triangles of its mesh at least (20, 80, ..., 5120, 20480, 81920)")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  AddFeatureOptions(*command, options->features, "surface, without friction");
  command->add_option("--steps", options->steps, "Samples of steady sliding")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--repeats", options->repeats, "Identical runs, for the time of a step")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--json", options->json, "Write one JSON object to FILE (- is stdout)");
  command->add_option("--plot", options->plot, "Draw the errors over time into FILE.svg");
  command->callback([options] { Run(*options); });
}

}  // namespace palpate::bench
