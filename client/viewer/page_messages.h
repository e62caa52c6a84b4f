#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/dds/wire.h"
#include "common/math/pose.h"

namespace palpate {

/// As text of one line.  Names come from elsewhere, and need not be UTF-8: what is none is
/// replaced.
/// @tparam Json  nlohmann::json, which is slow to compile and so in no header.
template <class Json>
std::string ToText(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// What pages publish, as JSON, and what they are told of a replay.  Each Parse throws Error for
// what is none.

/// On the channel /palpate/mouse:
///   {"op": "take", "scene": NAME, "tool": NAME}          the tool may be left out
///   {"op": "pose", "p": [x, y, z], "q": [w, x, y, z]}    where the tool is dragged to, in W
///   {"op": "release"}
///   {"op": "whole", "scene": NAME}                       makes a cut scene whole again
///   {"op": "bookmark" | "back", "scene": NAME}           keeps how it stands; makes it so again
struct MouseCommand {
  enum class Op { kTake, kPose, kRelease, kWhole, kBookmark, kBack };
  Op op = Op::kRelease;
  std::string scene;
  std::string tool;
  Pose X_WT;  ///< finite; its rotation need not be unit
};
MouseCommand ParseMouseCommand(std::string_view json);

/// Of a teacher's page, on the channel /palpate/operate, these fields and no others:
///   {"op": "admit" | "take_back" | "mute" | "unmute", "station": NAME}
///   {"op": "goal", "scene": NAME, "text": TEXT, "limit_N": NUMBER}
struct OperateCommand {
  /// What students are told of a scene.
  struct Goal {
    static constexpr std::size_t kLongest = 480;  ///< bytes: 120 letters of any script
    std::string scene;
    std::string text;    ///< empty, with no limit: there is no goal any more
    double limit = 0.0;  ///< of the force [N]; 0: none
  };
  wire::OperateWish wish = palpate_OPERATE_ADMIT;
  std::string station;
  std::optional<Goal> goal;  ///< then the rest does not count
};
OperateCommand ParseOperateCommand(std::string_view json);

/// "admit", "take_back", "mute", "unmute".
std::string_view OperateWishName(wire::OperateWish wish);

/// Of a person of a course, on the channel /palpate/trial, these fields and no others:
///   {"op": "begin", "exercise": NAME}
///   {"op": "stop"}
///   {"op": "submit", "exercise": NAME, "n": NUMBER}    hands it in; one that is running ends
struct TrialCommand {
  enum class Op { kBegin, kStop, kSubmit };
  Op op = Op::kStop;
  std::string exercise;
  int n = 0;
};
TrialCommand ParseTrialCommand(std::string_view json);

/// On the channel /palpate/replay.  64 bits that are a name travel as text in hexadecimal digits,
/// here and below: a number of JavaScript has 53.
///   {"replay": "5f3a…", "tag": 7, "wish": "play"}         or "pause"
///   {"replay": "5f3a…", "tag": 8, "wish": "seek", "value": 12.5}
///   {"replay": "5f3a…", "tag": 9, "wish": "rate", "value": 0.5}
///   {"replay": "5f3a…", "tag": 10, "wish": "add_bookmark", "value": 12.5, "text": "the slip"}
///   {"replay": "5f3a…", "tag": 11, "wish": "drop_bookmark", "value": 3}
struct ReplayWish {
  std::uint32_t tag = 0;  ///< the page's own, by which it knows the answer
  /// Without `request` and `by`, which the gateway gives.  Its value is finite.
  wire::ReplayRequest request{};
};
ReplayWish ParseReplayWish(std::string_view json);

/// What the gateway answers at once, to this page alone: the number by which ReplayState answers,
/// or why nobody is asked.
std::string ReplayAnswer(std::uint32_t tag, std::uint64_t request, const std::string& refusal);

/// idl/replay.idl, field by field; `begun_s` is the wall clock's time [s], kinds are words such as
/// "bookmark".
std::string ToJson(const wire::ReplayContents& contents);
std::string ToJson(const wire::ReplayState& state);

}  // namespace palpate
