#include "tests/benchmarks/scene_run.h"

#include "scenes/catalogue.h"
#include "server/session/scene_model.h"

namespace palpate::bench {
namespace {

Scene Load(const std::string& scene, const std::string& models_dir) {
  LoadOptions options;
  options.models_dir = models_dir;
  return LoadScene(scene, options);
}

}  // namespace

SceneRun::SceneRun(const std::string& scene, const std::string& models_dir, std::vector<Pose> poses)
    : SceneRun(Load(scene, models_dir), std::move(poses)) {}

SceneRun::SceneRun(Scene scene, std::vector<Pose> poses)
    : scene_(std::move(scene)), poses_(std::move(poses)) {
  model_ = std::make_unique<HapticModel>(MakeModel(scene_, tool(), MakeObjects(scene_)));
  workspace_ = std::make_unique<StepWorkspace>(*model_);
  start_.X_WG = ResolveStart(*model_, poses_.front(), *workspace_).X_WG;
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
