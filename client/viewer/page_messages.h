#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/dds/wire.h"
#include "common/math/pose.h"

namespace palpate {

/// Returns JSON as one line of text.  Bytes that are not UTF-8, as in names from
/// elsewhere, are replaced.
/// @tparam Json  nlohmann::json, which is slow to compile and therefore in no header.
template <class Json>
std::string ToText(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// The JSON messages that pages publish, and those that tell them about a replay.  Each Parse
// function throws Error if the message is invalid.

/// On the channel /palpate/mouse:
///   {"op": "take", "scene": NAME, "tool": NAME}          the tool may be left out
///   {"op": "pose", "p": [x, y, z], "q": [w, x, y, z]}    where the tool is dragged to, in W
///   {"op": "release"}
///   {"op": "whole", "scene": NAME}                       restores a scene that was cut
///   {"op": "bookmark" | "back", "scene": NAME}           keeps its state; restores that state
struct MouseCommand {
  enum class Op { kTake, kPose, kRelease, kWhole, kBookmark, kBack };
  Op op = Op::kRelease;
  std::string scene;
  std::string tool;
  Pose X_WT;           ///< finite; the rotation need not be a unit quaternion
  bool still = false;  ///< a bur stands still there
};
MouseCommand ParseMouseCommand(std::string_view json);

/// A command of a teacher's page, on the channel /palpate/operate.  Only these fields are accepted:
///   {"op": "admit" | "take_back" | "mute" | "unmute", "station": NAME}
///   {"op": "goal", "scene": NAME, "text": TEXT, "limit_N": NUMBER}
struct OperateCommand {
  /// A goal that students of a scene are told.
  struct Goal {
    static constexpr std::size_t kLongest = 480;  ///< bytes: 120 characters of any script
    std::string scene;
    std::string text;    ///< empty without a limit: the goal is removed
    double limit = 0.0;  ///< force limit [N]; 0: none
  };
  wire::OperateWish wish = palpate_OPERATE_ADMIT;
  std::string station;
  std::optional<Goal> goal;  ///< if set, the other fields do not count
};
OperateCommand ParseOperateCommand(std::string_view json);

/// Returns "admit", "take_back", "mute" or "unmute".
std::string_view OperateWishName(wire::OperateWish wish);

/// A command of a person of a course, on the channel /palpate/trial.  Only these
/// fields are accepted:
///   {"op": "begin", "exercise": NAME, "tool": NAME}    without a tool: the exercise's
///   {"op": "stop"}
///   {"op": "submit", "exercise": NAME, "n": NUMBER}    submits it; a running one ends
struct TrialCommand {
  enum class Op { kBegin, kStop, kSubmit };
  Op op = Op::kStop;
  std::string exercise, tool;
  int n = 0;
};
TrialCommand ParseTrialCommand(std::string_view json);

/// A wish on the channel /palpate/replay.  Here and below, 64-bit identifiers are hexadecimal text,
/// since a JavaScript number has 53 bits.
///   {"replay": "5f3a…", "tag": 7, "wish": "play"}         or "pause"
///   {"replay": "5f3a…", "tag": 8, "wish": "seek", "value": 12.5}
///   {"replay": "5f3a…", "tag": 9, "wish": "rate", "value": 0.5}
///   {"replay": "5f3a…", "tag": 10, "wish": "add_bookmark", "value": 12.5, "text": "the slip"}
///   {"replay": "5f3a…", "tag": 11, "wish": "drop_bookmark", "value": 3}
struct ReplayWish {
  std::uint32_t tag = 0;  ///< chosen by the page and repeated in the answer
  /// Lacks `request` and `by`, which the gateway fills in.  Its value is finite.
  wire::ReplayRequest request{};
};
ReplayWish ParseReplayWish(std::string_view json);

/// Returns the gateway's immediate answer to this page only: the request number that ReplayState
/// will answer, or why the wish was refused.
std::string ReplayAnswer(std::uint32_t tag, std::uint64_t request, const std::string& refusal);

/// Fields as in idl/replay.idl; `begun_s` is wall-clock time [s], kinds are words
/// such as "bookmark".
std::string ToJson(const wire::ReplayContents& contents);
std::string ToJson(const wire::ReplayState& state);

}  // namespace palpate
