// palpate-bench cycle: the time of one haptic step, and its errors.
#include <optional>

#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/cycle_report.h"
#include "tests/benchmarks/features.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/pose_source.h"
#include "tests/benchmarks/scene_run.h"

namespace palpate::bench {
namespace {

struct CycleCommand {
  std::string scene = "bunny-bunny";
  std::string poses;
  std::optional<int> steps;
  CycleOptions cycle;
  FeatureOptions features;
  std::string models;
  std::string json;
};

void Run(CycleCommand& options) {
  std::vector<Pose> poses =
      options.poses.empty() ? ScriptPoses(options.scene, options.steps) : ReadPoses(options.poses);
  if (options.steps && !options.poses.empty() &&
      poses.size() > static_cast<std::size_t>(*options.steps)) {
    poses.resize(static_cast<std::size_t>(*options.steps));
  }
  Scene scene = LoadForBench(options.scene, options.models, options.features.contact_model());
  options.features.ApplyTo(scene);
  options.cycle.name = options.scene;
  SceneRun run(std::move(scene), std::move(poses));
  const Json json = ReportCycle(run, options.cycle);
  if (!options.json.empty()) WriteJson(options.json, json);
}

}  // namespace

void AddCycle(const CommandLine& app) {
  auto options = std::make_shared<CycleCommand>();
  const CommandLine command = app.AddCommand(
      "cycle",
      "time and errors of a haptic step over the path of a scene\n"
      "Errors are the penetration of the meshes, the steps in which the tool does not\n"
      "arrive, the deviation from the converged force, and the cause of each jump of\n"
      "the force.  Unsupported force and torque are the part of the spring's pull that\n"
      "no contact bears where the tool has arrived, by a judge that shares no code with\n"
      "the step; right is 0.  Each judged place is nudged by 3 um and 0.3 mrad, and\n"
      "freed if that costs over 1 % of the spring's energy within 60 steps; of these,\n"
      "static friction alone held those that dynamic friction would not.");
  command.Footer("Example: palpate-bench cycle --scene bunny-bunny --steps 20000 --repeats 5");
  Add(command, "--scene", options->scene, "name in the catalogue, or scene file");
  Add(command, "--poses", options->poses,
      "haptic poses instead of the scene's script (CSV: x,y,z,qw,qx,qy,qz, one row per "
      "millisecond)");
  AddPathSteps(command, options->steps);
  options->cycle.AddTo(command);
  command.AddFlag("--subsample", options->cycle.quarter_steps,
                  "also run the path at 4 kHz and compare the forces");
  options->features.AddTo(command);
  AddModels(command, options->models);
  AddJson(command, options->json);
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
