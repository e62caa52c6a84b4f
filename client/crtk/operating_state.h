#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "common/dds/wire.h"
#include "common/step_fault.h"

namespace palpate {

/// A station as CRTK's operating_state tells of it.
struct CrtkState {
  const char* state = "DISABLED";  ///< DISABLED, ENABLED, PAUSED or FAULT
  bool homed = false;              ///< its poses are those of a hand in the scene
  bool busy = false;               ///< on its way to a state where forces are computed
  bool operator==(const CrtkState&) const = default;
};

/// @param faults  of the newest wrench.
inline CrtkState CrtkStateOf(wire::SessionPhase phase, bool muted, std::uint32_t faults) {
  switch (phase) {
    case palpate_SESSION_WAITING:
      return {"DISABLED", false, true};
    case palpate_SESSION_ACQUIRING:
      return {"PAUSED", true, true};
    case palpate_SESSION_ACTIVE:
      if (muted) return {"PAUSED", true, false};
      if ((faults & (kFaultBadPose | kFaultPoseRejected | kFaultUnsolved)) != 0) {
        return {"FAULT", true, false};
      }
      return {"ENABLED", true, false};
    default:
      return {};
  }
}

/// What a state_command asks of the server; none where a station has no such thing (it homes its
/// device itself) or the word is none of CRTK's.
inline std::optional<wire::OperateWish> WishOf(std::string_view command, wire::SessionPhase phase) {
  if (command == "pause") return palpate_OPERATE_MUTE;
  if (command == "resume" || command == "unpause") return palpate_OPERATE_UNMUTE;
  if (command == "enable") {
    return phase == palpate_SESSION_HELD ? palpate_OPERATE_ADMIT : palpate_OPERATE_UNMUTE;
  }
  if (command == "disable") return palpate_OPERATE_TAKE_BACK;
  return std::nullopt;
}

}  // namespace palpate
