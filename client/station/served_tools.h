#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/dds/participant.h"
#include "common/json/pose_script.h"
#include "common/math/pose.h"
#include "common/program/stop_signal.h"

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

/// Waits so long; true: give up.
using WaitOrStop = std::function<bool(std::chrono::nanoseconds)>;

/// What the server of a domain offers, by its own word: no file is looked for.
/// @param service  a participant of that domain, over that network.
/// @param scene    its name, or the file that the server has it from, in whatever folder; empty:
///                 all that there is.  The tools of each scene are in its order.
/// Empty where `wait` gave up.  Throws Error where no server answers, or has no such scene.
std::vector<OfferedTool> AskForTools(const dds::Participant& service, const AskOptions& options,
                                     const std::string& scene, const WaitOrStop& wait);
/// Until a signal comes.
inline std::vector<OfferedTool> AskForTools(const dds::Participant& service,
                                            const AskOptions& options, const std::string& scene,
                                            StopSignal& stop) {
  return AskForTools(service, options, scene,
                     [&](std::chrono::nanoseconds time) { return stop.WaitFor(time); });
}

/// The tool of that name, or the first: where that is not what was meant, the server says so when
/// it is asked for a session.
/// @param tools  at least one.   @param name  empty: the first.
const OfferedTool& Meant(const std::vector<OfferedTool>& tools, const std::string& name);

/// The message where no server answers: what to do.
std::string NobodyAnswers(int domain, const dds::Network& network, const std::string& scene);
/// The message where one is there whose samples are of other types than this program's, so that
/// DDS passes none between the two.
std::string AnotherVersionIsThere(int domain);

}  // namespace palpate
