#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "server/physics/haptic_step.h"

namespace palpate::bench {

/// The input of a measurement of the step: a scene's first tool, its model, and poses for it.
class SceneRun {
 public:
  /// Uses the scene's features.
  SceneRun(Scene scene, std::vector<Pose> poses);

  /// Makes one pass over all poses.  Fills in `reports` if given.
  /// @returns the time of each step [us].
  std::vector<double> Time(std::vector<StepReport>* reports = nullptr);

  const Scene& scene() const { return scene_; }
  const Body& tool() const { return scene_.tools.front(); }
  const HapticModel& model() const { return *model_; }
  const std::vector<Pose>& poses() const { return poses_; }
  int object_spheres() const;
  /// Returns the initial state of every repeat: the graphic tool at the resolved first pose.
  StepState Start() const;
  StepWorkspace& workspace() { return *workspace_; }

 private:
  Scene scene_;
  std::unique_ptr<HapticModel> model_;
  std::unique_ptr<StepWorkspace> workspace_;
  std::vector<Pose> poses_;
  StepState start_;
};

/// Loads a scene as LoadScene does, or makes one of test::kSharpScenes, and reports on stderr while
/// something is built.
/// @param contact  LoadOptions::contact.
Scene LoadForBench(const std::string& scene, const std::string& models_dir,
                   std::optional<ContactModel> contact = {});

/// Returns poses as CSV such that --poses of cycle reads back the same bits.
std::string PosesCsv(const std::vector<Pose>& poses);

}  // namespace palpate::bench
