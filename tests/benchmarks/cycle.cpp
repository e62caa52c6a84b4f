// palpate-bench cycle: the time of one haptic step, and what it is right by.
#include <algorithm>
#include <optional>

#include <spdlog/fmt/fmt.h>

#include "common/output.h"
#include "scenes/scene_remains.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/sphere_tree_query.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/features.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/overlap_oracle.h"
#include "tests/benchmarks/pose_source.h"
#include "tests/benchmarks/scene_run.h"
#include "tests/benchmarks/step_trace.h"
#include "tests/support/mesh_oracle.h"

namespace palpate::bench {
namespace {

struct Options {
  std::string scene = "bunny-bunny";
  std::string poses;
  std::optional<int> steps;
  int repeats = 5;
  FeatureOptions features;
  std::string models;
  std::string json;
  std::string trace;
  int check_every = 1;
};

/// One pass with the stages timed, which costs time of its own.
void StagedPass(SceneRun& run, BestOf stage[4]) {
  StepState state = run.Start();
  std::vector<double> us[4];
  for (const Pose& X_WH : run.poses()) {
    StageTimes times;
    HapticStep(run.model(), X_WH, state, run.workspace(), &times);
    const std::int64_t ns[4] = {times.prediction, times.rows, times.solve, times.response};
    for (int s = 0; s < 4; ++s) us[s].push_back(1e-3 * static_cast<double>(ns[s]));
  }
  for (int s = 0; s < 4; ++s) stage[s].Add(us[s]);
}

void Run(const Options& options) {
  std::vector<Pose> poses =
      options.poses.empty() ? ScriptPoses(options.scene, options.steps) : ReadPoses(options.poses);
  if (options.steps && !options.poses.empty() &&
      poses.size() > static_cast<std::size_t>(*options.steps)) {
    poses.resize(static_cast<std::size_t>(*options.steps));
  }
  Scene scene = LoadForBench(options.scene, options.models);
  options.features.ApplyTo(scene);
  SceneRun run(std::move(scene), std::move(poses));
  const std::size_t steps = run.poses().size();

  BestOf step, stage[4];
  std::vector<StepReport> reports;
  for (int r = 0; r < options.repeats; ++r) {
    Progress(fmt::format("{}: repeat {} of {} ...", options.scene, r + 1, options.repeats));
    step.Add(run.Time(r == 0 ? &reports : nullptr));
    StagedPass(run, stage);
  }

  // Everything else comes from the reports and from an oracle that knows nothing of the trees.
  OverlapOracle oracle(run.tool().tree, run.scene().objects, run.scene().features);
  test::MeshOracle meshes(run.scene());
  SceneRemains remains(run.scene());
  const ObjectForest& forest = run.model().objects();
  // Of spheres the contact is between leaves, of surfaces between meshes.
  const bool surface = run.scene().features.contact == ContactModel::kSurface;
  LeafWear wear = run.Start().wear;
  std::vector<double> predicted, conventional, penetration, depth, truncation, iterations, newton;
  int unsolved = 0, jammed = 0, far = 0, lowered = 0, rubs_unsolved = 0, meet = 0;
  double force_jump = 0.0, torque_jump = 0.0;
  for (std::size_t i = 0; i < steps; ++i) {
    const StepReport& report = reports[i];
    predicted.push_back(report.predicted_pairs);
    truncation.push_back(1e6 * report.truncation);
    iterations.push_back(report.qp_iterations);
    unsolved += (report.faults & kFaultUnsolved) != 0;
    jammed += (report.faults & kFaultJammed) != 0;
    far += (report.faults & kFaultTargetFar) != 0;
    newton.push_back(report.friction_iterations);
    lowered += report.friction_lowered;
    rubs_unsolved += report.friction_unsolved;
    if (i > 0) {
      const Wrench &now = report.wrench, &before = reports[i - 1].wrench;
      force_jump = std::max(force_jump, (now.force - before.force).norm());
      torque_jump = std::max(torque_jump, (now.torque - before.torque).norm());
    }
    if (i % static_cast<std::size_t>(options.check_every) == 0) {
      if (i % 500 == 0) {
        Progress(fmt::format("{}: checking step {} of {} ...", options.scene, i, steps));
      }
      const test::MeshOracle::Overlap overlap = meshes.At(report.X_WG);
      depth.push_back(1e6 * overlap.depth);
      meet += overlap.meet;
      penetration.push_back(surface ? depth.back() : 1e6 * oracle.At(report.X_WG, &wear).depth);
      conventional.push_back(static_cast<double>(oracle.At(run.poses()[i], &wear).pairs));
    }
    for (int r = 0; r < report.removals; ++r) {
      const std::int32_t leaf = report.removed[static_cast<std::size_t>(r)];
      wear.Remove(leaf);
      const int object = forest.ObjectOf(leaf);
      for (const std::uint32_t triangle :
           remains.Remove(static_cast<std::uint32_t>(object),
                          static_cast<std::uint32_t>(leaf - forest.FirstLeafOf(object)))) {
        meshes.Remove(static_cast<std::size_t>(object), triangle);
      }
    }
  }
  Progress("");

  const Percentiles best = PercentilesOf(step.best()), raw = PercentilesOf(step.all());
  const Features& features = run.scene().features;
  const char* stage_name[4] = {"prediction", "rows", "solve", "response"};
  Table table(fmt::format(
      "{}, contact {}, friction {}: {} tool spheres, {} object spheres, {} "
      "steps, best of {} ({})",
      options.scene, NameOf(features.contact), NameOf(features.friction), run.tool().tree.leaves(),
      run.object_spheres(), steps, options.repeats, ActiveKernels().name));
  nlohmann::ordered_json json{{"scene", options.scene},
                              {"contact", NameOf(features.contact)},
                              {"friction", NameOf(features.friction)},
                              {"tool_spheres", run.tool().tree.leaves()},
                              {"object_spheres", run.object_spheres()},
                              {"steps", steps},
                              {"repeats", options.repeats},
                              {"simd", ActiveKernels().name},
                              {"best_step_us", ToJson(best)},
                              {"raw_step_us", ToJson(raw)}};
  table.Row("step, best", "us", best);
  table.Row("step, raw", "us", raw);
  for (int s = 0; s < 4; ++s) {
    const Percentiles p = PercentilesOf(stage[s].best());
    table.Row(std::string("  ") + stage_name[s] + ", best", "us", p);
    json["best_stage_us"][stage_name[s]] = ToJson(p);
  }
  const auto add = [&](const char* name, const char* unit, std::vector<double> values,
                       nlohmann::ordered_json& out) {
    const Percentiles p = PercentilesOf(std::move(values));
    table.Row(name, unit, p);
    out = ToJson(p);
  };
  add("pairs, predicted", "", std::move(predicted), json["pairs"]["predicted"]);
  add("pairs, conventional", "", std::move(conventional), json["pairs"]["conventional"]);
  add("penetration", "um", std::move(penetration), json["penetration_um"]);
  const auto checked = static_cast<double>(depth.size());
  const auto over_1um = static_cast<double>(
      std::count_if(depth.begin(), depth.end(), [](double um) { return um > 1.0; }));
  add("penetration of meshes", "um", std::move(depth), json["mesh_penetration_um"]);
  json["mesh_penetration_um"]["share_over_1um"] = over_1um / checked;
  json["mesh_intersecting_fraction"] = meet / checked;
  table.Line("meshes intersect", fmt::format("{:.2f} % of the poses, deeper than 1 um {:.2f} %",
                                             100.0 * meet / checked, 100.0 * over_1um / checked));
  add("truncation, bound", "um", std::move(truncation), json["truncation_um"]);
  add("QP iterations", "", std::move(iterations), json["qp"]["iterations"]);
  json["qp"]["unsolved"] = unsolved;
  if (features.friction == FrictionModel::kCoulomb) {
    nlohmann::ordered_json& rubs = json["friction_solver"];
    add("friction's Newton steps", "", std::move(newton), rubs["iterations"]);
    rubs["lowered"] = lowered;
    rubs["unsolved"] = rubs_unsolved;
    table.Line("friction's limits lowered",
               fmt::format("{} (unsolved {})", lowered, rubs_unsolved));
  }
  json["jump"] = {{"force_N_max", force_jump}, {"torque_Nm_max", torque_jump}};
  json["steps_jammed"] = jammed;
  json["steps_target_far"] = far;
  table.Line("QPs unsolved",
             fmt::format("{} (jammed steps {}, target far {})", unsolved, jammed, far));
  table.Line("greatest jump", fmt::format("{:.3f} N, {:.4f} N m", force_jump, torque_jump));
  table.Print();
  if (!options.trace.empty()) {
    WriteOutput("--trace", options.trace, StepTrace(run.poses(), reports, step.best()));
  }
  if (!options.json.empty()) WriteJson(options.json, json);
}

}  // namespace

void AddCycle(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "cycle",
      "Time of one haptic step over a scene's path, with penetration by brute force.\n"
      "Example: palpate-bench cycle --scene bunny-bunny --steps 20000 --repeats 5");
  command->add_option("--scene", options->scene, "Catalogue name or scene file")
      ->capture_default_str();
  command->add_option(
      "--poses", options->poses,
      "Haptic poses instead of the scene's script: CSV x,y,z,qw,qx,qy,qz, a row a ms");
  command->add_option("--steps", options->steps, "Steps (default: the whole path)")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--repeats", options->repeats,
                   "Identical runs; 'best' is the least of each step")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  options->features.AddTo(*command);
  command->add_option("--models", options->models, "Folder of models that are not packaged");
  command
      ->add_option("--check-every", options->check_every,
                   "Check penetration at every n-th step only")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--trace", options->trace,
                      "Write poses and wrench of every step to FILE, as CSV (- is stdout)");
  command->add_option("--json", options->json, "Write one JSON object to FILE (- is stdout)");
  command->callback([options] { Run(*options); });
}

}  // namespace palpate::bench
