#pragma once

#include "client/crtk/options.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// Brings the stations of one server to ROS 2 until it is stopped.  Throws Error.
void Bridge(const CrtkOptions& options, StopSignal& stop);

}  // namespace palpate
