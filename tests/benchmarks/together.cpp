// palpate-bench together: two tools that feel each other, beside a tool on an object at rest.
#include <algorithm>
#include <chrono>
#include <memory>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "server/physics/haptic_step.h"
#include "server/physics/scene_model.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/pose_source.h"
#include "tests/benchmarks/scene_run.h"

namespace palpate::bench {
namespace {

struct Options {
  std::string scene, models, json;
  std::optional<int> steps;
  int repeats = 5;
};

/// The scene's first tool, and its only object held by a second hand that stands at its place.
class TwoHands {
 public:
  explicit TwoHands(const SceneRun& run)
      : start_(run.Start()), X_of_object_(run.scene().objects.front().X_WB) {
    const Body &tool = run.tool(), &object = run.scene().objects.front();
    const PlacedTree held{.tree = &object.tree,
                          .mesh = &object.mesh,
                          .leaf_material = object.leaf_material,
                          .materials = object.materials,
                          .frame = 1,
                          .tool = 1};
    // A model needs an object; this one is out of reach.
    const PlacedTree far{
        .tree = &tool.tree, .X_WB = {Vec3(10.0, 0.0, 0.0), Quat::Identity()}, .mesh = &tool.mesh};
    const auto add = [&](const Body& body, const PlacedTree& touches) {
      models_.emplace_back(
          body.tree,
          std::make_shared<const SceneObjects>(std::span(&touches, 1), ContactModel::kSurface),
          run.model().parameters(), &body.mesh);
    };
    models_.reserve(2);
    add(tool, held);
    add(object, far);
    for (const HapticModel& model : models_) workspaces_.emplace_back(model);
    const HapticModel* both[] = {&models_[0], &models_[1]};
    together_ = std::make_unique<TogetherWorkspace>(both);
  }

  /// Makes one pass over the poses of the first hand; returns the time of each step [us].
  std::vector<double> Time(const std::vector<Pose>& poses, int& late, double& unbalanced) {
    std::vector<StepState> states;
    for (const HapticModel& model : models_) states.emplace_back(model);
    states[0].X_WG = start_.X_WG;
    states[0].X_WH = poses.front();
    states[1].X_WG = states[1].X_WH = X_of_object_;
    ToolStep steps[] = {{&models_[0], {}, &states[0], &workspaces_[0]},
                        {&models_[1], X_of_object_, &states[1], &workspaces_[1]}};
    late = 0;
    std::vector<double> step_us;
    for (const Pose& X_WH : poses) {
      steps[0].X_WH = X_WH;
      const auto begin = std::chrono::steady_clock::now();
      StepTogether(steps, *together_);
      const auto end = std::chrono::steady_clock::now();
      step_us.push_back(std::chrono::duration<double, std::micro>(end - begin).count());
      const bool is_late = (steps[0].report.faults & kFaultTargetFar) != 0;
      late += is_late ? 1 : 0;
      const Vec3 &a = steps[0].report.wrench.force, &b = steps[1].report.wrench.force;
      if (!is_late) unbalanced = std::max(unbalanced, (a + b).norm() / std::max(1e-3, a.norm()));
    }
    return step_us;
  }

 private:
  StepState start_;
  Pose X_of_object_;
  std::vector<HapticModel> models_;
  std::vector<StepWorkspace> workspaces_;
  std::unique_ptr<TogetherWorkspace> together_;
};

void Run(const Options& options) {
  SceneRun run(LoadForBench(options.scene, options.models, ContactModel::kSurface),
               ScriptPoses(options.scene, options.steps));
  if (run.scene().objects.size() != 1 || run.model().bodies().size() != 1 ||
      !run.model().solids().empty() || run.model().is_ball()) {
    throw Error("together: scene '" + options.scene +
                "' must have one object, rigid and of a mesh, and a tool that is no ball; take "
                "bunny-bunny");
  }
  TwoHands hands(run);
  BestOf alone, together;
  std::vector<StepReport> reports;
  int late = 0;
  double unbalanced = 0.0;
  for (int i = 0; i < options.repeats; ++i) {
    alone.Add(run.Time(&reports));
    together.Add(hands.Time(run.poses(), late, unbalanced));
  }
  const auto late_alone = std::ranges::count_if(
      reports, [](const StepReport& report) { return (report.faults & kFaultTargetFar) != 0; });
  const Percentiles one = PercentilesOf(alone.best()), two = PercentilesOf(together.best());
  Table table(
      fmt::format("{}: {} steps, best of {}", options.scene, run.poses().size(), options.repeats));
  table.Row("a tool on an object at rest", "us", one);
  table.Row("two tools", "us", two);
  table.Line("two tools over one",
             fmt::format("p50 {:.2f}, p99 {:.2f}, p99.9 {:.2f}", two.p50 / one.p50,
                         two.p99 / one.p99, two.p999 / one.p999));
  table.Line("late", fmt::format("{}; two tools {}", late_alone, late));
  table.Line("forces of two, unbalanced", fmt::format("{:.2g} of either, at most", unbalanced));
  table.Print();
  if (options.json.empty()) return;
  WriteJson(options.json, {{"scene", options.scene},
                           {"repeats", options.repeats},
                           {"machine", ToJson(ThisMachine())},
                           {"steps", run.poses().size()},
                           {"alone_us", ToJson(one)},
                           {"together_us", ToJson(two)},
                           {"late_alone", late_alone},
                           {"late_together", late},
                           {"unbalanced_max", unbalanced}});
}

}  // namespace

void AddTogether(const CommandLine& app) {
  auto options = std::make_shared<Options>();
  const CommandLine command = app.AddCommand(
      "together",
      "two tools that feel each other\n"
      "The scene's object is held by a second hand that stands still. Beside it, in\n"
      "turns: the same tool on the object at rest.");
  command.Footer("Example: palpate-bench together --scene bunny-bunny");
  Add(command, "--scene", options->scene, "scene of one tool and one object").Required();
  AddPathSteps(command, options->steps);
  AddRepeats(command, options->repeats);
  AddModels(command, options->models);
  AddJson(command, options->json);
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
