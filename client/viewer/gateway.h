#pragma once

#include "client/viewer/options.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// Serves until a signal comes.  One thread does it all: HTTP, WebSockets, and 120 times a second
/// what DDS's readers hold; each message is serialised once, by its writer, and shared by viewers.
/// Throws Error.
void RunGateway(const ViewerOptions& options, StopSignal& stop);

}  // namespace palpate
