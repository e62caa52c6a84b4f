#pragma once

#include <array>

#include "common/dds/wire.h"

namespace palpate {

/// The phases of a session that has not ended.
inline constexpr std::array kLivePhases = {palpate_SESSION_WAITING, palpate_SESSION_ACQUIRING,
                                           palpate_SESSION_ACTIVE};

inline bool IsOver(const wire::SessionState& state) {
  return state.phase == palpate_SESSION_ENDED || state.phase == palpate_SESSION_REFUSED;
}

/// Returns a phase as a word that programs can read.
constexpr const char* PhaseName(wire::SessionPhase phase) {
  switch (phase) {
    case palpate_SESSION_WAITING:
      return "waiting";
    case palpate_SESSION_ACQUIRING:
      return "acquiring";
    case palpate_SESSION_ACTIVE:
      return "active";
    case palpate_SESSION_REFUSED:
      return "refused";
    case palpate_SESSION_ENDED:
      return "ended";
    case palpate_SESSION_HELD:
      return "held";
    default:
      return "other";
  }
}

}  // namespace palpate
