#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/json/pose_script.h"
#include "scenes/scene.h"
#include "server/session/session.h"

namespace palpate {

/// A scene as stations are told of it, so that they need no file of it, and its tools as they are
/// driven.
struct ServedScene {
  struct Tool {
    std::shared_ptr<const ServedTool> served;
    Pose X_WT;                          ///< where the scene places it
    std::vector<PoseScript::Key> hand;  ///< of this tool alone; none: the scene's
    std::string remark;                 ///< of that hand, or why there is none; in a sentence
  };
  std::string name;
  std::string file;  ///< where it is from, without its folder
  std::vector<PoseScript::Key>
      hand;  ///< of the script beside the scene's file; none: there is none
  std::vector<Tool> tools;
};

/// What stations can drive in a scene.  The scene itself (its meshes) is not kept.
/// @param name_or_path  the scene's, as LoadScene takes it: a hand's script may stand beside it.
///                      Where there is none, each tool gets a hand that is made for it.
/// Throws Error where the script is wrong.
ServedScene ServeScene(const Scene& scene, const std::string& name_or_path,
                       std::uint64_t hand_seed);

/// One more of it under another name, with the same models.
ServedScene SeatOf(const ServedScene& scene, const std::string& name);

}  // namespace palpate
