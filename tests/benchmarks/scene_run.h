#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "scenes/tree/tree_source.h"
#include "server/physics/haptic_step.h"

namespace palpate::bench {

/// A scene's first tool, its model, and poses for it: what every measurement of the step starts
/// from.
class SceneRun {
 public:
  /// With the scene's features.
  SceneRun(Scene scene, std::vector<Pose> poses);

  /// One pass over all poses.  `reports` is filled where given.
  /// @returns the time of each step [us].
  std::vector<double> Time(std::vector<StepReport>* reports = nullptr);

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

/// Loads a scene as LoadScene does, or makes one of test::kSharpScenes, and says so on stderr while
/// something is built.
/// @param contact    LoadOptions::contact.
/// @param tree_file  LoadOptions::tree_file, where it names one.
Scene LoadForBench(const std::string& scene, const std::string& models_dir,
                   std::optional<ContactModel> contact = {}, const TreeSource& tree_file = {});

/// How far the forces of a path are from the true ones, of the mean of those; 0 where that is 0.
struct ForceDifference {
  double force = 0.0, force_max = 0.0, torque = 0.0;
};
ForceDifference DifferenceOf(const std::vector<Wrench>& felt, const std::vector<Wrench>& truth);

}  // namespace palpate::bench
