#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/json/pose_script.h"
#include "scenes/scene.h"
#include "server/session/session.h"

namespace palpate {

/// A scene in the form in which it is offered to stations, which therefore need no scene file, with
/// its tools as sessions drive them.
struct ServedScene {
  struct Tool {
    std::shared_ptr<const ServedTool> served;
    Pose X_WT;                          ///< its pose in the scene
    std::vector<PoseScript::Key> hand;  ///< for this tool alone; if empty, the scene's
    std::string remark;                 ///< a sentence about that hand, or why there is none
  };
  std::string name;
  std::string file;                   ///< name of the scene's file, without its folder
  std::vector<PoseScript::Key> hand;  ///< script beside the scene's file; empty if there is none
  std::vector<Tool> tools;
};

/// Returns what stations can drive in a scene.  The scene itself (its meshes) is not kept.
/// @param name_or_path  as LoadScene takes it.  A script of a hand may stand beside the scene's
///                      file; if there is none, each tool gets a generated hand.
/// Throws Error if the script is wrong.
ServedScene ServeScene(const Scene& scene, const std::string& name_or_path,
                       std::uint64_t hand_seed);

/// Returns the same scene under another name, with the same models.
ServedScene SeatOf(const ServedScene& scene, const std::string& name);

}  // namespace palpate
