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

/// A tool that a server offers to stations.
struct OfferedTool {
  std::string scene, tool;
  Pose X_WT{};                     ///< pose in which the scene places it
  std::optional<PoseScript> hand;  ///< scripted motion of a hand with it, if the server knows one
  /// One sentence that says where the script comes from if none was written for the tool, or why
  /// there is none.
  std::string remark;

  /// Returns the pose in which a hand begins.
  Pose Start() const { return hand ? hand->At(0.0) : X_WT; }
};

/// Where to ask for tools, and for how long.
struct AskOptions {
  int domain = 0;
  dds::Network network;
  double wait_s = 10.0;  ///< for a server's answer
};

/// Waits for the given time; returns true to give up.
using WaitOrStop = std::function<bool(std::chrono::nanoseconds)>;

/// Returns the tools that the server of a domain reports; reads no local file.
/// @param service  a participant of that domain, over that network.
/// @param scene    its name, or the file from which the server loaded it, in any folder; empty: all
///                 scenes.  The tools of each scene are in its order.
/// Returns empty if `wait` gave up.  Throws Error if no server answers, or it has no such scene.
std::vector<OfferedTool> AskForTools(const dds::Participant& service, const AskOptions& options,
                                     const std::string& scene, const WaitOrStop& wait);
/// Waits until a signal arrives.
inline std::vector<OfferedTool> AskForTools(const dds::Participant& service,
                                            const AskOptions& options, const std::string& scene,
                                            StopSignal& stop) {
  return AskForTools(service, options, scene,
                     [&](std::chrono::nanoseconds time) { return stop.WaitFor(time); });
}

/// Returns the tool of that name, or the first one.  If that is the wrong tool, the server reports
/// it when asked for a session.
/// @param tools  at least one.   @param name  empty: the first.
const OfferedTool& Meant(const std::vector<OfferedTool>& tools, const std::string& name);

/// Returns the error message for a domain in which no server answers, with remedies.
std::string NobodyAnswers(int domain, const dds::Network& network, const std::string& scene);
/// Returns the error message for a server whose sample types differ from this program's, so that
/// DDS exchanges no samples between the two.
std::string AnotherVersionIsThere(int domain);

}  // namespace palpate
