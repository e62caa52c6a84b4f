#pragma once

#include <string>
#include <vector>

#include "common/dds/participant.h"
#include "common/math/pose.h"
#include "common/stop_signal.h"

namespace palpate {

/// A tool that a station can ask a server for.
struct OfferedTool {
  std::string scene, tool;
  Pose X_WT;  ///< where it starts
};

/// What the server of a domain offers, by the scenes that it publishes: scenes by their names, the
/// tools of each in its order.
/// @param scene  a scene's name; empty: all.   @param wait_s  for the first word of a server.
/// Empty where `stop` came first.  Throws Error where no server answers, or has no such scene.
std::vector<OfferedTool> AskForTools(const dds::Participant& service, int domain,
                                     const std::string& scene, double wait_s, StopSignal& stop);

}  // namespace palpate
