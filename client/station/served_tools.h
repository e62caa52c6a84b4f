#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/dds/participant.h"
#include "common/json/pose_script.h"
#include "common/math/pose.h"
#include "common/stop_signal.h"

namespace palpate {

/// A tool that a station can ask a server for.
struct OfferedTool {
  std::string scene, tool;
  Pose X_WT{};                     ///< where the scene places it
  std::optional<PoseScript> hand;  ///< what a hand does with it, where the server knows
  /// In a sentence, how that hand came about where no script was written for it, or why there is
  /// none.
  std::string remark;

  /// Where a hand begins.
  Pose Start() const { return hand ? hand->At(0.0) : X_WT; }
};

/// Where to ask, and for how long.
struct AskOptions {
  int domain = 0;
  dds::Network network;
  double wait_s = 10.0;  ///< for the word of a server
};

/// What the server of a domain offers, by its own word: no file is looked for.
/// @param service  a participant of that domain, over that network.
/// @param scene    its name, or the file that the server has it from, in whatever folder; empty:
/// all
///                 that there is.  The tools of each scene are in its order.
/// Empty where `stop` came first.  Throws Error where no server answers, or has no such scene.
std::vector<OfferedTool> AskForTools(const dds::Participant& service, const AskOptions& options,
                                     const std::string& scene, StopSignal& stop);

/// The message where no server answers: what to do.
std::string NobodyAnswers(int domain, const dds::Network& network, const std::string& scene);

}  // namespace palpate
