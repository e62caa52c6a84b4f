#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/dds/wire.h"

namespace palpate {

// A replay and its steering as JSON, for pages.  64 bits that are a name travel as text in
// hexadecimal digits: a number of JavaScript has 53.

/// idl/replay.idl, field by field; `begun_s` is the wall clock's time [s], kinds are words such as
/// "bookmark".
std::string ToJson(const wire::ReplayContents& contents);
std::string ToJson(const wire::ReplayState& state);

/// What a page wishes of a replay, on the channel /palpate/replay:
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

/// Throws Error for what is none.
ReplayWish ParseReplayWish(std::string_view json);

/// What the gateway answers at once, to this page alone: the number by which ReplayState answers,
/// or why nobody is asked.
std::string ReplayAnswer(std::uint32_t tag, std::uint64_t request, const std::string& refusal);

}  // namespace palpate
