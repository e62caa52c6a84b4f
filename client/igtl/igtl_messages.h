#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/dds/wire.h"

namespace palpate {

/// Returns a station's name shortened for OpenIGTLink, whose names have 20 characters including the
/// suffix: at most 13 characters.  A longer name becomes its beginning plus four digits hashed from
/// the whole name.
std::string IgtlName(const std::string& station);

/// Returns a tool's state as consecutive OpenIGTLink messages (protocol version 1), ready to send:
///   TRANSFORM NAME         the tool's pose, in millimetres and in RAS: X_RAS = C X_W, where
///                          C is the rotation from the scene's axes (y up, z forward) to
///                          Slicer's: (x, y, z) -> (-x, z, y)
///   SENSOR    NAME_force   the force on the hand [N], in RAS
///   SENSOR    NAME_torque  the torque about the tool's reference point [N m], in RAS
/// Returns nothing if a number of the pose is not finite; a force that is not finite is
/// sent unchanged.
/// @param system_ns  the messages' time stamp.
std::vector<std::uint8_t> IgtlMessages(const wire::ToolState& tool, std::int64_t system_ns);

}  // namespace palpate
