#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "client/replayer/hand_path.h"
#include "client/replayer/verify/verify.h"
#include "common/json/pose_script.h"

namespace palpate {

/// What a hand does in a scene, and what it leaves of it.
struct Performance {
  HandPath path;
  std::optional<SolidsCut> cut;  ///< where the scene has something to cut
};

/// A scene, and its objects as the step wants them.
struct PlayedScene {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const SceneObjects> objects;
};

/// A scripted hand in a session of its own, a pose each millisecond, with the scene whole at first:
/// what a recording of it would hold.
/// @param tool  the name of one of the scene's.   @param until_s  no more of the script [s].
/// Throws Error where there is no such tool.
Performance Perform(const PlayedScene& played, const std::string& tool, const PoseScript& script,
                    double until_s = std::numeric_limits<double>::infinity());

/// A scene that a recording holds.  Throws Error where it does not.
PlayedScene SceneIn(const std::string& recording, const std::string& name);

}  // namespace palpate
