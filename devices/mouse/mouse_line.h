#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/math/pose.h"

namespace palpate {

/// What a mouse's hand is told by a line of text.
struct MouseLine {
  std::optional<Pose> X_WT;  ///< where the tool is dragged to; none: it is let go
};

/// Reads `x y z qw qx qy qz` (metres; a rotation, which need not be of unit length; in W) or
/// `release`.  Nothing, with the reason, for anything else: not seven finite numbers, beyond 10 m,
/// or a quaternion without length.
std::optional<MouseLine> ParseMouseLine(std::string_view line, std::string& complaint);

}  // namespace palpate
