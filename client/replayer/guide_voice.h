#pragma once

#include "client/replayer/options.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// Leads the hand of a station along the recorded hand's path, at the recorded pace times a rate,
/// until its end or a signal; waits where the hand stays behind (guide_pace.h).  The station
/// decides with how much force, and whether at all. Throws Error where the recording holds no path.
void Guide(const ReplayOptions& options, StopSignal& stop);

}  // namespace palpate
