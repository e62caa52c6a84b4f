#pragma once

#include <memory>
#include <optional>
#include <string>

#include "client/replayer/hand_path.h"
#include "client/replayer/verify/verify.h"
#include "common/json/pose_script.h"

namespace palpate {

/// The path of a hand in a scene, and what it left of the solids.
struct Performance {
  HandPath path;
  std::optional<SolidsCut> cut;  ///< present if the scene has something to cut
};

/// A scene, with its objects prepared for the step.
struct PlayedScene {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const SceneObjects> objects;
};

/// Simulates a scripted hand in a session of its own, one pose per millisecond, with the scene
/// whole at first.  Returns what a recording of it would hold.
/// @param tool  name of a tool of the scene.  Throws Error if there is no such tool.
Performance Perform(const PlayedScene& played, const std::string& tool, const PoseScript& script);

/// Returns a scene that a recording holds.  Throws Error if it holds none of that name.
PlayedScene SceneIn(const std::string& recording, const std::string& name);

}  // namespace palpate
