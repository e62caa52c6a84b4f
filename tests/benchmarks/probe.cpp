// palpate-bench probe: a dental probe on a solid for burs, whole and cut, and on its mesh.
#include <algorithm>
#include <chrono>
#include <optional>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "scenes/catalogue.h"
#include "scenes/grid/solid_surface.h"
#include "scenes/shapes/dental_shapes.h"
#include "server/physics/haptic_step.h"
#include "server/physics/scene_model.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/pose_source.h"
#include "tests/support/hand_path.h"
#include "tests/support/mesh_oracle.h"
#include "tests/support/test_scenes.h"

namespace palpate::bench {
namespace {

constexpr double kTip = 0.4e-3, kLength = 60e-3;  ///< radius of the probe's end, and its length [m]

struct Options {
  std::string scene = "caries";
  test::HandOptions hand{.seed = 1, .speed = 0.05, .steps = 10000, .press_mm = 1.0};
  int repeats = 3;
  std::string json;
};

/// Makes a scene with a probe instead of its tools, and one object, as a solid or as a mesh.
Scene WithProbe(const Scene& of, const Body& solid) {
  Scene scene;
  scene.name = of.name;
  scene.coupling = of.coupling;
  scene.tools.push_back(test::MakeMeshBody("probe", MakeProbe(kTip, kLength)));
  scene.objects.push_back(solid);
  return scene;
}

Scene AsMesh(Scene scene, TriangleMesh mesh) {
  Body& object = scene.objects.front();
  object = test::MakeMeshBody(object.name, std::move(mesh), object.X_WB);
  return scene;
}

/// Removes what the scene's first tool cuts if it follows its script exactly, through everything.
void CutByScript(const Scene& scene, const CutSolid& solid, CutField& cut) {
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  const Cutting& cutting = *model.cutting();
  const Pose X_BW = solid.X_WB.Inverse();
  constexpr std::size_t kStride = 10;  // a hundredth of a second
  const std::vector<Pose> way = ScriptPoses(scene.name, std::nullopt);
  for (std::size_t n = kStride; n < way.size(); n += kStride) {
    const Pose from = X_BW * way[n - kStride] * cutting.X_TB, to = X_BW * way[n] * cutting.X_TB;
    cut.Remove(cutting.bur, from, to.p - from.p);
  }
}

struct Measured {
  Percentiles us;
  int entered = 0, touched = 0, behind = 0;
};

Measured Measure(const HapticModel& model, const std::vector<Pose>& hand, const StepState& start,
                 const test::MeshOracle& oracle, int repeats) {
  BestOf times;
  Measured measured;
  StepWorkspace workspace(model);
  for (int r = 0; r < repeats; ++r) {
    StepState state = start;
    state.X_WG = state.X_WH = hand.front();
    state.ForgetContact();
    std::vector<double> us;
    for (const Pose& X_WH : hand) {
      const auto begin = std::chrono::steady_clock::now();
      const StepReport report = HapticStep(model, X_WH, state, workspace);
      us.push_back(
          std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin)
              .count());
      if (r > 0) continue;
      measured.touched += report.contacts > 0;
      measured.behind += (report.faults & kFaultTargetFar) != 0;
      measured.entered += oracle.Meet(report.X_WG);
    }
    times.Add(us);
  }
  measured.us = PercentilesOf(times.best());
  return measured;
}

Measured MeasureMesh(const Scene& scene, const std::vector<Pose>& hand, int repeats) {
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  return Measure(model, hand, StepState(model), test::MeshOracle(scene), repeats);
}

void Run(const Options& options) {
  const Scene scene = LoadScene(options.scene);
  const auto solid =
      std::ranges::find_if(scene.objects, [](const Body& b) { return b.grid.has_value(); });
  if (solid == scene.objects.end()) {
    throw Error(scene.name + ": nothing of it can be cut; give an object \"grid_um\"");
  }
  const Scene with_probe = WithProbe(scene, *solid);
  const HapticModel model =
      MakeModel(with_probe, with_probe.tools.front(), MakeObjects(with_probe));
  StepState whole(model), cut(model);
  CutByScript(scene, model.solids().front(), cut.cut.fields.front());

  Table table(fmt::format("{}: a probe, {} steps", scene.name, options.hand.steps));
  Json json{{"machine", ToJson(ThisMachine())}, {"scene", scene.name}};
  for (const bool is_cut : {false, true}) {
    const StepState& start = is_cut ? cut : whole;
    const SolidSurface surface = WholeSurface(start.cut.fields.front());
    const Scene drawn = AsMesh(with_probe, {surface.vertices, surface.triangles});
    const std::vector<Pose> hand = test::MakeHand(drawn, options.hand);
    const Measured felt = Measure(model, hand, start, test::MeshOracle(drawn), options.repeats);
    const Measured same = MeasureMesh(drawn, hand, options.repeats);
    const std::string name = is_cut ? "cut" : "whole";
    table.Row(name + ": solid", "us", felt.us);
    table.Row(name + ": its surface as a mesh", "us", same.us);
    json[name] = {{"triangles", surface.triangles.size()},
                  {"solid_us", ToJson(felt.us)},
                  {"surface_us", ToJson(same.us)},
                  {"touched", felt.touched},
                  {"behind", felt.behind},
                  {"entered", felt.entered}};
    if (!is_cut) {
      const Measured mesh = MeasureMesh(AsMesh(with_probe, solid->mesh), hand, options.repeats);
      table.Row("its own mesh", "us", mesh.us);
      json[name]["mesh_us"] = ToJson(mesh.us);
    }
    table.Line(name, fmt::format("{} triangles; touched in {} steps, behind in {} (mesh {}), "
                                 "entered in {}",
                                 surface.triangles.size(), felt.touched, felt.behind, same.behind,
                                 felt.entered));
  }
  table.Print();
  if (!options.json.empty()) WriteJson(options.json, json);
}

}  // namespace

void AddProbe(const CommandLine& app) {
  auto options = std::make_shared<Options>();
  const CommandLine command = app.AddCommand(
      "probe",
      "time of a step of a dental probe on a solid that burs can cut\n"
      "Measured before and after the scene's script has cut it; compared with the same\n"
      "triangles as a mesh, and with the solid's original mesh.  Also counts how often\n"
      "the probe enters the drawn surface.");
  command.Footer("Example: palpate-bench probe --scene caries --json probe.json");
  Add(command, "--scene", options->scene, "scene with a bur, from the catalogue or a file");
  Add(command, "--steps", options->hand.steps, "number of steps, one per millisecond");
  Add(command, "--seed", options->hand.seed, "seed of the hand's path");
  AddRepeats(command, options->repeats);
  AddJson(command, options->json);
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
