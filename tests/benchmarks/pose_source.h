#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/math/pose.h"

namespace palpate::bench {

/// Reads haptic poses, one per millisecond, from a file of rows `x,y,z,qw,qx,qy,qz` (m and a unit
/// quaternion, in W; an optional first line of names).  Throws Error with file and line.
std::vector<Pose> ReadPoses(const std::string& file);

/// Samples the scene's own script (`<scene>.path.json` beside it) once per millisecond. Without
/// `steps` it is sampled once through; if `steps` exceeds its length, repeatedly.
std::vector<Pose> ScriptPoses(const std::string& scene, std::optional<int> steps);

}  // namespace palpate::bench
