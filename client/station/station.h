#pragma once

#include "client/station/options.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// Runs a station until its time is over or a signal comes, and prints its summary.  Throws Error;
/// where a hand was served before, after the summary.
void RunStation(const StationOptions& options, StopSignal& stop);

}  // namespace palpate
