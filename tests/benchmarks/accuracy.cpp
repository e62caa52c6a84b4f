// palpate-bench accuracy: force against analytic truth, the chapter's 2.5.1 (eq. 2.36,
// Figs. 2.16-2.18).
#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <optional>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "common/plot/svg_plot.h"
#include "scenes/mesh/mesh_query.h"
#include "server/physics/simd/kernels.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/features.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/sliding_force.h"
#include "tests/benchmarks/tree_file_option.h"

namespace palpate::bench {
namespace {

struct Options {
  SlidingExperiment experiment;
  std::string mode;  ///< empty: what suits the contact
  std::vector<std::size_t> spheres{64, 512, 4096};
  FeatureOptions features{"surface", "off"};
  TreeSource file;  ///< beside the trees that are built; none where it names no file
  std::string json, plot;
  std::vector<std::string> draw;
};

/// "A polygonal mesh with over 4,000 triangles", which the chapter compares 64 spheres with.
constexpr std::size_t kComparedTriangles = 4001;

nlohmann::ordered_json ToJson(const MeanMax& m) {
  return {{"mean", m.mean}, {"max", m.max}};
}

void AddTo(nlohmann::ordered_json& json, const ForceErrors& e) {
  json["force_error"] = {{"x", ToJson(e.axis[0])},
                         {"y", ToJson(e.axis[1])},
                         {"z", ToJson(e.axis[2])},
                         {"magnitude", ToJson(e.magnitude)},
                         {"strength", ToJson(e.strength)}};
  json["direction_deg"] = ToJson(e.direction_deg);
}

std::string Columns(const ForceErrors& e) {
  return fmt::format("{:>8.5f} {:>8.5f}  {:>8.5f} {:>8.5f}  {:>7.3f} {:>7.3f}", e.magnitude.mean,
                     e.magnitude.max, e.strength.mean, e.strength.max, e.direction_deg.mean,
                     e.direction_deg.max);
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

nlohmann::ordered_json ToJson(const SlidingForce& m) {
  nlohmann::ordered_json json{
      {"spheres", m.spheres}, {"triangles", m.triangles}, {"felt_triangles", m.felt_triangles}};
  AddTo(json, m.errors);
  json["truncation_um"] = ToJson(m.truncation_um);
  json["best_step_us"] = ToJson(PercentilesOf(m.step_us.best()));
  return json;
}

/// As Figs. 2.17 and 2.18: the error of each component over time.
void WritePlot(const Options& options, const std::vector<SlidingForce>& rows) {
  std::vector<Plot> plots;
  for (const char axis : {'x', 'y'}) {
    Plot plot{.title = fmt::format("Force error along {}: ball on the {}, {} contact", axis,
                                   options.experiment.object, options.features.contact),
              .x = {.title = "Time of steady sliding [ms]"},
              .y = {.title = "Error, of the true 1 N [-]"},
              .height = 240};
    if (axis == 'x') plot.subtitle = "δF of eq. 2.36 against the analytic object";
    for (const SlidingForce& row : rows) {
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

/// What a run has written with --json.
nlohmann::json ReadRun(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw Error(file + ": cannot be opened; make one with accuracy --json");
  nlohmann::json run = nlohmann::json::parse(in, nullptr, false);
  if (!run.is_object() || !run.contains("object") || !run.contains("contact")) {
    throw Error(file + ": is not what accuracy --json writes; name files of that alone");
  }
  return run;
}

/// Error by count of spheres, a line for each of the runs.
void DrawRuns(const Options& options) {
  std::vector<Plot> plots;
  for (const auto& [which, name] : {std::pair("mean", "mean"), std::pair("max", "greatest")}) {
    Plot plot{.title = fmt::format("Force error against the analytic truth, {}", name),
              .subtitle = "A ball of 5 mm slides with 1 N over a cube and an ellipsoid",
              .x = {.title = "Spheres of the object's tree", .log = true},
              .y = {.title = "|δF| of eq. 2.36 [of 1 N]", .log = true, .min = 1e-4},
              .height = 220};
    for (const std::string& file : options.draw) {
      const nlohmann::json run = ReadRun(file);
      const bool spheres = run["contact"] == "spheres";
      PlotSeries series{.name = fmt::format("{}, {} contact", run["object"].get<std::string>(),
                                            spheres ? "sphere" : "surface"),
                        .style = PlotSeries::Style::kLineAndPoints};
      for (const auto& row : run.contains("results") ? run["results"] : nlohmann::json{run}) {
        series.x.push_back(row.at("spheres"));
        series.y.push_back(row.at("force_error").at("magnitude").at(which));
      }
      plot.series.push_back(std::move(series));
    }
    plot.references = {{.value = 0.08, .text = "just noticed: 8 %"},
                       {.value = 0.06, .text = "6 %"}};
    plots.push_back(std::move(plot));
  }
  WriteSvg(options.plot, plots);
}

void Run(Options options) {
  if (!options.draw.empty()) {
    if (options.plot.empty()) throw UsageError("accuracy: --draw needs --plot FILE.svg");
    DrawRuns(options);
    return;
  }
  options.experiment.features = options.features.features();
  if (options.mode.empty()) options.mode = NameOf(ModeFor(options.experiment.features.contact));
  options.experiment.tree.mode = TreeModeNamed(options.mode);
  std::vector<SlidingForce> rows;
  for (const std::size_t spheres : options.spheres) {
    rows.push_back(MeasureSlidingForce(options.experiment, spheres));
  }
  std::optional<SlidingForce> of_file;
  if (!options.file.built()) {
    SlidingExperiment experiment = options.experiment;
    experiment.tree = options.file;
    of_file = MeasureSlidingForce(experiment, 0);
  }

  std::string table = fmt::format(
      "{}, {} contact: a ball of 5 mm slides at 1 N, {} samples, best of {} ({})\n"
      "  {:<22} {:^17}  {:^17}  {:^15}  {:>10} {:>10}\n"
      "  {:<22} {:>8} {:>8}  {:>8} {:>8}  {:>7} {:>7}  {:>10} {:>10}\n",
      options.experiment.object, options.features.contact, options.experiment.steps,
      options.experiment.repeats, ActiveKernels().name, "", "force error |dF|", "of the strength",
      "direction, deg", "truncation", "step p99.9", "spheres", "mean", "max", "mean", "max", "mean",
      "max", "max, um", "us");
  const auto add_row = [&](const SlidingForce& row, const std::string& name) {
    table += fmt::format("  {:<22} {}  {:>10.4f} {:>10.2f}\n", name, Columns(row.errors),
                         row.truncation_um.max, PercentilesOf(row.step_us.best()).p999);
  };
  for (const SlidingForce& row : rows) add_row(row, fmt::format("{}", row.spheres));
  if (of_file) add_row(*of_file, fmt::format("{}, of the file", of_file->spheres));
  nlohmann::ordered_json json{{"object", options.experiment.object},
                              {"contact", options.features.contact},
                              {"mode", options.mode},
                              {"steps", options.experiment.steps},
                              {"repeats", options.experiment.repeats},
                              {"simd", ActiveKernels().name},
                              {"machine", ToJson(ThisMachine())}};
  if (rows.size() == 1) {
    json.update(ToJson(rows.front()));
  } else {
    for (const SlidingForce& row : rows) json["results"].push_back(ToJson(row));
  }
  if (of_file) {
    json["tree_file"] = ToJson(*of_file);
    json["tree_file"]["file"] = options.file.file;
  }
  if (!options.experiment.cube()) {
    const TriangleMesh mesh = ObjectMesh(options.experiment, kComparedTriangles);
    const ForceErrors on_mesh = OnMesh(PathOf(options.experiment), mesh);
    table += fmt::format("  {:<22} {}\n", fmt::format("mesh, {} triangles", mesh.triangles.size()),
                         Columns(on_mesh));
    json["mesh"]["triangles"] = mesh.triangles.size();
    AddTo(json["mesh"], on_mesh);
  }
  table += options.experiment.cube()
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
  command
      ->add_option("--object", options->experiment.object,
                   "cube (50 mm) or ellipsoid (40, 25, 30 mm)")
      ->check(CLI::IsMember({"cube", "ellipsoid"}))
      ->capture_default_str();
  command->add_option("--spheres", options->spheres, "Leaves of the object's tree; a row for each")
      ->delimiter(',')
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--triangles", options->experiment.triangles,
                   "Ellipsoid: triangles of its mesh at least (20, 80, ..., 5120, 20480, 81920)")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option_function<double>(
          "--tolerance-um", [options](double um) { options->experiment.tolerance = 1e-6 * um; },
          "Ellipsoid, surface contact: how truly that mesh stands for a curved surface, as a "
          "scene's \"curved\" says; 0: felt as it is  [3]")
      ->check(CLI::Range(0.0, 1e6));
  options->features.AddTo(*command);
  command
      ->add_option("--mode", options->mode,
                   "Mode of the object's tree (default: balanced for spheres, else inside)")
      ->check(CLI::IsMember(std::vector<std::string>(kTreeModes.begin(), kTreeModes.end())));
  AddTreeFileOptions(*command, "m", options->file)->needs(command->get_option("--tree"));
  command->add_option("--steps", options->experiment.steps, "Samples of steady sliding")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--repeats", options->experiment.repeats,
                   "Identical runs, for the time of a step")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--json", options->json, "Write one JSON object to FILE (- is stdout)");
  command->add_option("--plot", options->plot, "Draw the errors over time into FILE.svg");
  command
      ->add_option("--draw", options->draw,
                   "Measure nothing: draw what runs have written with --json, error by count of "
                   "spheres, into the --plot")
      ->delimiter(',');
  command->callback([options] { Run(*options); });
}

}  // namespace palpate::bench
