#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "server/physics/haptic_step.h"

namespace palpate::bench {

/// What to measure instead of the scene's own features; empty: those.
struct FeatureOverrides {
  std::string contact;   ///< spheres, surface
  std::string friction;  ///< off, chapter, coulomb

  /// Sets the features of a scene.  Where friction is asked of one that names no coefficient, its
  /// materials get those of the chapter's 2.5.6, 0.8 and 0.3.
  void Apply(Scene& scene) const;
};

/// The names that FeatureOverrides and the JSON outputs use.
const char* NameOf(ContactModel contact);
const char* NameOf(FrictionModel friction);

/// A scene's first tool, its model, and poses for it: what every measurement of the step starts
/// from.
class SceneRun {
 public:
  /// `models_dir` as LoadScene takes it.  Says what it loads on stderr.
  SceneRun(const std::string& scene, const std::string& models_dir, std::vector<Pose> poses,
           const FeatureOverrides& overrides = {});
  SceneRun(Scene scene, std::vector<Pose> poses);

  const Scene& scene() const { return scene_; }
  const Body& tool() const { return scene_.tools.front(); }
  const HapticModel& model() const { return *model_; }
  const std::vector<Pose>& poses() const { return poses_; }
  int object_spheres() const;
  /// State in which every repeat begins: the graphic tool at the first pose, or out of the object
  /// that the first pose is in.
  StepState Start() const;
  StepWorkspace& workspace() { return *workspace_; }

 private:
  Scene scene_;
  std::unique_ptr<HapticModel> model_;
  std::unique_ptr<StepWorkspace> workspace_;
  std::vector<Pose> poses_;
  StepState start_;
};

}  // namespace palpate::bench
