// palpate-bench cut: a bur's volume, force, work and time, and the law of measured forces.
#include <memory>

#include "common/error.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/cut_fit.h"
#include "tests/benchmarks/cut_scene.h"

namespace palpate::bench {
namespace {

struct Options : CutSceneOptions {
  std::string fit;
};

void Run(const Options& options) {
  if (!options.fit.empty()) return RunCutFit(options.fit, options.json);
  if (options.scene.empty()) throw UsageError("cut needs --scene or --fit");
  RunCutScene(options);
}

}  // namespace

void AddCut(const CommandLine& app) {
  auto options = std::make_shared<Options>();
  const CommandLine command =
      app.AddCommand("cut",
                     "error of removed volume, force and work of a bur, and time of a step\n"
                     "With --scene: step, force, volume, work, surface and ripple of that scene.\n"
                     "With --fit: fits the cutting law to measured feeds and forces.");
  command.Footer(
      "Examples:\n"
      "  palpate-bench cut --scene caries --json cut.json\n"
      "  palpate-bench cut --fit feeds.csv");
  const Option scene =
      Add(command, "--scene", options->scene, "scene with a bur, from the catalogue or a file");
  Add(command, "--poses", options->poses,
      "haptic poses (CSV: x,y,z,qw,qx,qy,qz, one row per millisecond); default: the scene's "
      "script, else a plunge and a groove")
      .Needs(scene);
  Add(command, "--surface", options->surface, "write the remaining solids to FILE.stl, in metres")
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
  AddRepeats(command, options->repeats);
  AddJson(command, options->json);
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
