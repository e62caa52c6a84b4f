#pragma once

#include <string>
#include <string_view>

#include "common/math/pose.h"

namespace palpate {

/// What a page sends on the channel /palpate/mouse:
///   {"op": "take", "scene": NAME, "tool": NAME}          the tool may be left out
///   {"op": "pose", "p": [x, y, z], "q": [w, x, y, z]}    where the tool is dragged to, in W
///   {"op": "release"}
///   {"op": "whole", "scene": NAME}                       makes a worn scene whole again
struct MouseCommand {
  enum class Op { kTake, kPose, kRelease, kWhole };
  Op op = Op::kRelease;
  std::string scene;
  std::string tool;
  Pose X_WT;  ///< finite; its rotation need not be unit
};

/// Throws Error for what is none.
MouseCommand ParseMouseCommand(std::string_view json);

/// The pose as a line for a station's mouse device (devices/mouse/mouse_device.h), to the bit.
std::string ToMouseLine(const Pose& X_WT);

}  // namespace palpate
