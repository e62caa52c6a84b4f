#pragma once

#include "client/recorder/options.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// Records until its time is over or a signal comes.  Throws Error, with what is recorded by then
/// whole in the file.
void Record(const RecorderOptions& options, StopSignal& stop);

}  // namespace palpate
