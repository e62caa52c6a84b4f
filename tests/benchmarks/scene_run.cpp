#include "tests/benchmarks/scene_run.h"

#include <algorithm>

#include "scenes/catalogue.h"
#include "server/session/scene_model.h"

namespace palpate::bench {
namespace {

Scene Load(const std::string& name, const std::string& models_dir,
           const FeatureOverrides& overrides) {
  LoadOptions options;
  options.models_dir = models_dir;
  Scene scene = LoadScene(name, options);
  overrides.Apply(scene);
  return scene;
}

}  // namespace

void FeatureOverrides::Apply(Scene& scene) const {
  for (const ContactModel model : {ContactModel::kSpheres, ContactModel::kSurface}) {
    if (contact == NameOf(model)) scene.features.contact = model;
  }
  for (const FrictionModel model :
       {FrictionModel::kOff, FrictionModel::kChapter, FrictionModel::kCoulomb}) {
    if (friction == NameOf(model)) scene.features.friction = model;
  }
  if (friction.empty() || scene.features.friction == FrictionModel::kOff) return;
  const bool rough = std::any_of(scene.objects.begin(), scene.objects.end(), [](const Body& body) {
    return std::any_of(body.materials.begin(), body.materials.end(),
                       [](const Material& material) { return material.static_friction > 0.0; });
  });
  if (rough) return;
  for (Body& body : scene.objects) {
    for (Material& material : body.materials) {
      material.static_friction = 0.8;
      material.dynamic_friction = 0.3;
    }
  }
}

const char* NameOf(ContactModel contact) {
  return contact == ContactModel::kSurface ? "surface" : "spheres";
}

const char* NameOf(FrictionModel friction) {
  switch (friction) {
    case FrictionModel::kChapter:
      return "chapter";
    case FrictionModel::kCoulomb:
      return "coulomb";
    case FrictionModel::kOff:
      break;
  }
  return "off";
}

SceneRun::SceneRun(const std::string& scene, const std::string& models_dir, std::vector<Pose> poses,
                   const FeatureOverrides& overrides)
    : SceneRun(Load(scene, models_dir, overrides), std::move(poses)) {}

SceneRun::SceneRun(Scene scene, std::vector<Pose> poses)
    : scene_(std::move(scene)), poses_(std::move(poses)) {
  model_ = std::make_unique<HapticModel>(MakeModel(scene_, tool(), MakeObjects(scene_)));
  workspace_ = std::make_unique<StepWorkspace>(*model_);
  start_ = StepState(*model_);
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
