#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

/// Steps a scene's tool along poses of the haptic tool, one a millisecond, by the server's own
/// loop, and records it as the session of a station: for viewers, for others' programs, and to be
/// verified.  Forces are on from the first pose, and ramp in as in a session.
struct StepsOptions {
  std::string poses;       ///< file: a row a millisecond, x,y,z or x,y,z,qw,qx,qy,qz
  std::string scene;       ///< as LoadScene takes it
  std::string tool;        ///< empty: the scene's only one
  std::string file;        ///< recording to write; must not exist
  std::string models_dir;  ///< of LoadOptions
};
/// Throws Error.
void RecordSteps(const StepsOptions& options);

/// Reads such a file of poses; rows without numbers at its beginning are titles.  Throws Error
/// (file, line).
std::vector<Pose> ReadPoses(const std::string& file);

}  // namespace palpate
