#pragma once

#include "client/load/options.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// Does what the options ask for, until it is done or a signal comes.  Throws Error.
void RunLoad(const LoadRunOptions& options, StopSignal& stop);

}  // namespace palpate
