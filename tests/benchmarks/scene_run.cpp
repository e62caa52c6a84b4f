#include "tests/benchmarks/scene_run.h"

#include <algorithm>
#include <chrono>

#include <spdlog/fmt/fmt.h>

#include "scenes/catalogue.h"
#include "scenes/progress_line.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "tests/benchmarks/figures.h"
#include "tests/support/sharp_bodies.h"

namespace palpate::bench {

Scene LoadForBench(const std::string& scene, const std::string& models_dir,
                   std::optional<ContactModel> contact) {
  if (std::optional<Scene> sharp = test::MakeSharpScene(scene)) {
    if (contact) sharp->features.contact = *contact;
    return *std::move(sharp);
  }
  LoadOptions options;
  options.contact = contact;
  options.models_dir = models_dir;
  options.progress = [text = ProgressText()](std::string_view stage, double fraction) mutable {
    Progress(text(stage, fraction));
  };
  return LoadScene(scene, options);
}

std::string PosesCsv(const std::vector<Pose>& poses) {
  std::string csv = "x,y,z,qw,qx,qy,qz\n";
  for (const Pose& X : poses) {
    csv += fmt::format("{},{},{},{},{},{},{}\n", X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(),
                       X.q.y(), X.q.z());
  }
  return csv;
}

SceneRun::SceneRun(Scene scene, std::vector<Pose> poses)
    : scene_(std::move(scene)), poses_(std::move(poses)) {
  model_ = std::make_unique<HapticModel>(MakeModel(scene_, tool(), MakeObjects(scene_)));
  workspace_ = std::make_unique<StepWorkspace>(*model_);
  start_ = StepState(*model_);
  start_.X_WG = ResolveStart(*model_, poses_.front(), *workspace_).X_WG;
}

std::vector<double> SceneRun::Time(std::vector<StepReport>* reports) {
  using Clock = std::chrono::steady_clock;
  StepState state = Start();
  std::vector<double> step_us;
  step_us.reserve(poses_.size());
  if (reports != nullptr) {
    reports->clear();
    reports->reserve(poses_.size());
  }
  for (const Pose& X_WH : poses_) {
    const auto begin = Clock::now();
    const StepReport report = HapticStep(*model_, X_WH, state, *workspace_);
    const auto end = Clock::now();
    step_us.push_back(std::chrono::duration<double, std::micro>(end - begin).count());
    if (reports != nullptr) reports->push_back(report);
  }
  return step_us;
}

int SceneRun::object_spheres() const {
  std::size_t spheres = 0;
  for (const Body& object : scene_.objects) spheres += object.tree.leaves();
  return static_cast<int>(spheres);
}

StepState SceneRun::Start() const {
  return start_;
}

}  // namespace palpate::bench
