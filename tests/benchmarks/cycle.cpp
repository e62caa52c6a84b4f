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

struct Options {
  std::string scene = "bunny-bunny";
  std::string poses;
  std::optional<int> steps;
  CycleOptions cycle;
  FeatureOptions features;
  std::string models;
  std::string json;
};

void Run(Options& options) {
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
  auto options = std::make_shared<Options>();
  const CommandLine command = app.AddCommand(
      "cycle",
      "Time of one haptic step over a scene's path, and what is right about its contact: how deep\n"
      "the meshes are in each other, whether the tool arrives, how far the force is from the\n"
      "converged one, and the cause of every jump.\n"
      "Example: palpate-bench cycle --scene bunny-bunny --steps 20000 --repeats 5");
  Add(command, "--scene", options->scene, "Catalogue name or scene file");
  Add(command, "--poses", options->poses,
      "Haptic poses instead of the scene's script: CSV x,y,z,qw,qx,qy,qz, a row a ms");
  AddPathSteps(command, options->steps);
  options->cycle.AddTo(command);
  command.AddFlag("--subsample", options->cycle.quarter_steps,
                  "Run the path at 4 kHz too and compare the forces");
  options->features.AddTo(command);
  AddModels(command, options->models);
  AddJson(command, options->json);
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
