#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/dds/wire.h"

namespace palpate {

/// A station's name as OpenIGTLink can carry it, which has 20 letters for a name and what is told:
/// at most 13, where it is longer its beginning and four digits made of all of it.
std::string IgtlName(const std::string& station);

/// A tool's state as messages of OpenIGTLink (protocol version 1), one after the other, as they go
/// to a client:
///   TRANSFORM NAME         the tool's pose, in millimetres and in RAS: X_RAS = C X_W, where
///                          C takes the scene's axes (y up, z forward) to Slicer's:
///                          (x, y, z) -> (-x, z, y), which is a rotation
///   SENSOR    NAME_force   the force on the hand [N], in RAS
///   SENSOR    NAME_torque  the torque about the tool's reference point [N m], in RAS
/// Nothing where a number of the pose is not finite; a force that is not is told as it is.
/// @param system_ns  the messages' time stamp.
std::vector<std::uint8_t> IgtlMessages(const wire::ToolState& tool, std::int64_t system_ns);

}  // namespace palpate
