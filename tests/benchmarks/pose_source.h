#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/math/pose.h"

namespace palpate::bench {

/// Haptic poses, one a millisecond, from a file of rows `x,y,z,qw,qx,qy,qz` (m and a unit
/// quaternion, in W; an optional first line of names).  Throws Error with file and line.
std::vector<Pose> ReadPoses(const std::string& file);

/// The scene's own script (`<scene>.path.json` beside it), sampled once a millisecond.
/// Without `steps` it runs once through; with more than it has, again and again.
std::vector<Pose> ScriptPoses(const std::string& scene, std::optional<int> steps);

}  // namespace palpate::bench
