// palpate-bench levels: cost of finer and errors of coarser sphere trees (chapter, Fig. 2.23c).
#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "scenes/progress_line.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "scenes/tree/tree_error.h"
#include "server/physics/simd/kernels.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/features.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/pose_source.h"
#include "tests/benchmarks/scene_run.h"

namespace palpate::bench {
namespace {

struct Options {
  std::string scene = "dragon-buddha", models, json;
  // The maximum leaves per level of the chapter's trees with eight children per node, levels 1 to 5
  // (its bunny has 3,917 at level 4, its dragon 22,332 at level 5).
  std::vector<std::size_t> leaves{8, 64, 512, 3917, 22332};
  bool objects_only = false;
  std::optional<int> steps;
  int repeats = 3;
  FeatureOptions features{"spheres", "off"};
};

using Clock = std::chrono::steady_clock;

struct Level {
  std::size_t leaves = 0;
  std::size_t tool_spheres = 0, object_spheres = 0;
  double build_s = 0.0;
  Coverage coverage;  ///< of the first object
  BestOf step_us;
  std::vector<double> pairs, solve_us, prediction_us;
  std::vector<Wrench> wrenches;
  int unsolved = 0, overflowed = 0;
};

/// Returns the body with a tree of `leaves`.  A single ball is the same at any level.
void Refine(Body& body, std::size_t leaves, TreeMode mode) {
  if (body.tree.leaves() == 1 || body.tree.leaves() == leaves) return;
  ProgressText text;
  body.tree = BuildSphereTree(
      body.mesh, leaves,
      [&](std::string_view stage, double done) {
        Progress(text(fmt::format("{}, {} leaves: {}", body.name, leaves, stage), done));
      },
      mode);
  if (!body.leaf_material.empty()) {
    throw Error("levels: body '" + body.name +
                "' has materials on its leaves, which a tree of another size does not know; choose "
                "a scene without");
  }
}

Level Measure(const Options& options, const Scene& original, const std::vector<Pose>& poses,
              std::size_t leaves) {
  Level level;
  level.leaves = leaves;
  Scene scene = original;
  const auto began = Clock::now();
  const TreeMode mode = ModeFor(scene.features.contact);
  for (Body& object : scene.objects) Refine(object, leaves, mode);
  if (!options.objects_only) Refine(scene.tools.front(), leaves, mode);
  level.build_s = std::chrono::duration<double>(Clock::now() - began).count();
  level.coverage = MeasureCoverage(scene.objects.front().mesh, scene.objects.front().tree, 20000);

  SceneRun run(std::move(scene), poses);
  level.tool_spheres = run.tool().tree.leaves();
  level.object_spheres = static_cast<std::size_t>(run.object_spheres());
  std::vector<StepReport> reports;
  for (int r = 0; r < options.repeats; ++r) {
    Progress(fmt::format("{} leaves: repeat {} of {} ...", leaves, r + 1, options.repeats));
    level.step_us.Add(run.Time(&reports));
  }
  for (const StepReport& report : reports) {
    level.pairs.push_back(report.diagnostics.predicted_pairs);
    level.wrenches.push_back(report.wrench);
    level.unsolved += (report.faults & kFaultUnsolved) != 0;
    level.overflowed += (report.faults & kFaultRowsFull) != 0;
  }
  // Runs again with timed stages, because the chapter shows detection and optimisation separately.
  StepState state = run.Start();
  for (const Pose& X_WH : poses) {
    StageTimes times;
    HapticStep(run.model(), X_WH, state, run.workspace(), &times);
    level.prediction_us.push_back(1e-3 * static_cast<double>(times.prediction + times.rows));
    level.solve_us.push_back(1e-3 * static_cast<double>(times.solve));
  }
  Progress("");
  return level;
}

void Run(Options options) {
  Scene scene = LoadForBench(options.scene, options.models, options.features.contact_model());
  options.features.ApplyTo(scene);
  options.features = {NameOf(scene.features.contact), NameOf(scene.features.friction)};
  const std::vector<Pose> poses = ScriptPoses(options.scene, options.steps);
  std::vector<std::size_t> leaves = options.leaves;
  std::sort(leaves.begin(), leaves.end());
  std::vector<Level> levels;
  for (const std::size_t count : leaves) {
    levels.push_back(Measure(options, scene, poses, count));
  }

  std::string table = fmt::format(
      "{}, {} contact: {} steps, best of {} ({})\n"
      "  {:>8} {:>8}  {:>28}  {:>10} {:>10}  {:>13}  {:>16}  {:>15}  {:>8}\n"
      "  {:>8} {:>8}  {:>8} {:>9} {:>9}  {:>10} {:>10}  {:>6} {:>6}  {:>7} {:>8}  {:>7} {:>7}  "
      "{:>8}\n",
      options.scene, options.features.contact, poses.size(), options.repeats, ActiveKernels().name,
      "spheres", "", "step, best, us", "detection", "solving", "pairs", "uncovered, um",
      "against finest", "build", "tool", "objects", "p50", "p99", "p99.9", "p99.9 us", "p99.9 us",
      "p50", "max", "mean", "max", "force", "torque", "s");
  Json json{{"scene", options.scene},
            {"contact", options.features.contact},
            {"friction", options.features.friction},
            {"steps", poses.size()},
            {"repeats", options.repeats},
            {"simd", ActiveKernels().name},
            {"machine", ToJson(ThisMachine())}};
  for (const Level& level : levels) {
    const Percentiles best = PercentilesOf(level.step_us.best());
    const Percentiles detection = PercentilesOf(level.prediction_us);
    const Percentiles solving = PercentilesOf(level.solve_us);
    const Percentiles pairs = PercentilesOf(level.pairs);
    const Distribution& bare = level.coverage.uncovered;
    const ForceDifference off = DifferenceOf(level.wrenches, levels.back().wrenches);
    table += fmt::format(
        "  {:>8} {:>8}  {:>8.2f} {:>9.2f} {:>9.2f}  {:>10.2f} {:>10.2f}  {:>6.0f} {:>6.0f}  "
        "{:>7.1f} {:>8.1f}  {:>7.4f} {:>7.4f}  {:>8.2f}\n",
        level.tool_spheres, level.object_spheres, best.p50, best.p99, best.p999, detection.p999,
        solving.p999, pairs.p50, pairs.max, 1e6 * bare.mean, 1e6 * bare.max, off.force, off.torque,
        level.build_s);
    json["levels"].push_back(
        {{"leaves", level.leaves},
         {"tool_spheres", level.tool_spheres},
         {"object_spheres", level.object_spheres},
         {"build_s", level.build_s},
         {"best_step_us", ToJson(best)},
         {"raw_step_us", ToJson(PercentilesOf(level.step_us.all()))},
         {"raw_stage_us", {{"detection", ToJson(detection)}, {"solve", ToJson(solving)}}},
         {"pairs", ToJson(pairs)},
         {"uncovered_um",
          {{"mean", 1e6 * bare.mean}, {"p99", 1e6 * bare.p99}, {"max", 1e6 * bare.max}}},
         {"against_finest", {{"force", off.force}, {"torque", off.torque}}},
         {"unsolved", level.unsolved},
         {"rows_full", level.overflowed}});
  }
  table +=
      "  chapter, level 5 (22,332): detection below 1,000 us, optimisation below 1,000 us, at most "
      "about 500 pairs\n";
  std::fputs(table.c_str(), stderr);
  if (!options.json.empty()) WriteJson(options.json, json);
}

}  // namespace

void AddLevels(const CommandLine& app) {
  auto options = std::make_shared<Options>();
  const CommandLine command = app.AddCommand(
      "levels",
      "time and force error of a step by level of detail (chapter Fig. 2.23c)\n"
      "Runs the script of the scene with coarser and finer sphere trees, and compares\n"
      "the forces with those of the finest tree.");
  command.Footer(
      "Examples:\n"
      "  palpate-bench levels --scene dragon-buddha --json levels.json\n"
      "  palpate-bench levels --scene dragon-buddha --leaves 1000000 --objects-only");
  Add(command, "--scene", options->scene, "name in the catalogue, or scene file");
  Add(command, "--leaves", options->leaves, "leaves of each tree; one level for each number")
      .Range(std::size_t{2}, std::size_t{1} << 22);
  command.AddFlag("--objects-only", options->objects_only, "keep the tool's own tree");
  AddPathSteps(command, options->steps);
  AddRepeats(command, options->repeats);
  options->features.AddTo(command);
  AddModels(command, options->models);
  AddJson(command, options->json);
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
