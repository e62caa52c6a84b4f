#pragma once

#include <string>

#include "client/replayer/playback.h"
#include "common/program/stop_signal.h"

namespace palpate {

struct GuideOptions {
  std::string led;      ///< station to be guided
  std::string station;  ///< whose path guides it, as SessionChoice
  bool waits = true;    ///< for a hand that stays behind
};

/// Leads the hand of a station along the recorded hand's path, at the recorded pace times a rate,
/// until its end or a signal; waits where the hand stays behind (guide_pace.h).  The station
/// decides with how much force, and whether at all. Throws Error where the recording holds no path.
void Guide(const Playback& playback, const GuideOptions& options, StopSignal& stop);

}  // namespace palpate
