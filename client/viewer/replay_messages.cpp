#include "client/viewer/replay_messages.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <span>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "client/viewer/json_text.h"
#include "common/json/json_file.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

/// In the order of idl/replay.idl.
const std::vector<std::string_view> kWishes = {"play", "pause",        "seek",
                                               "rate", "add_bookmark", "drop_bookmark"};
constexpr std::array kMarks = {"bookmark", "session", "contact", "fault", "whole"};
constexpr std::size_t kLongestText = sizeof(wire::ReplayRequest::text) - 1;  // [bytes]

std::string Hex(std::uint64_t id) {
  return fmt::format("{:x}", id);
}

/// 1 to 16 digits, as Hex writes them, and not 0.
std::uint64_t ReadId(const JsonNode& node) {
  const std::string text = node.String();
  std::uint64_t id = 0;
  const char* end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, id, 16);
  if (error != std::errc{} || stopped != end || id == 0 || Hex(id) != text) {
    node.Fail("is not the replay's number as its state gives it, in hexadecimal digits");
  }
  return id;
}

void ReadName(const JsonNode& node, wire::ReplayRequest& request) {
  const std::string name = node.Text();
  if (name.size() > kLongestText) node.Fail("has more than 120 bytes");
  // The rest of it would be cut off without a word.
  if (name.find('\0') != std::string::npos) node.Fail("has a zero in it");
  wire::FromText(name, request.text);
}

}  // namespace

std::string ToJson(const wire::ReplayContents& contents) {
  Json marks = Json::array();
  for (const wire::ReplayMark& mark : std::span(contents.marks._buffer, contents.marks._length)) {
    const auto kind = static_cast<std::size_t>(mark.kind);
    marks.push_back({{"at_s", mark.at_s},
                     {"number", mark.number},
                     {"kind", kind < kMarks.size() ? kMarks[kind] : ""},
                     {"text", mark.text}});
  }
  Json gaps = Json::array();
  for (const wire::ReplayGap& gap : std::span(contents.gaps._buffer, contents.gaps._length)) {
    gaps.push_back({{"from_s", gap.from_s},
                    {"to_s", gap.to_s},
                    {"station", gap.station},
                    {"reason", gap.reason}});
  }
  return ToText(Json({{"replay", Hex(contents.replay)},
                      {"recording", contents.recording},
                      {"begun_s", 1e-9 * static_cast<double>(contents.begun_ns)},
                      {"length_s", contents.length_s},
                      {"locked", contents.locked},
                      {"marks", marks},
                      {"gaps", gaps}}));
}

std::string ToJson(const wire::ReplayState& state) {
  return ToText(Json({{"replay", Hex(state.replay)},
                      {"at_s", state.at_s},
                      {"rate", state.rate},
                      {"sought", state.sought},
                      {"playing", state.playing},
                      {"ended", state.ended},
                      {"request", Hex(state.request)},
                      {"refusal", state.refusal}}));
}

ReplayWish ParseReplayWish(std::string_view text) {
  const JsonNode json = JsonNode::Parse(text, "/palpate/replay");
  ReplayWish read;
  wire::ReplayRequest& request = read.request;
  request.replay = ReadId(json.At("replay"));
  read.tag = static_cast<std::uint32_t>(
      json.At("tag").Integer(0, std::numeric_limits<std::uint32_t>::max()));
  const auto wish = std::ranges::find(kWishes, json.At("wish").OneOf(kWishes));
  request.kind = static_cast<std::uint32_t>(wish - kWishes.begin());
  request.wish = static_cast<palpate_ReplayWish>(request.kind);
  if (request.wish == palpate_REPLAY_PLAY || request.wish == palpate_REPLAY_PAUSE) return read;
  request.value = json.At("value").Number();
  if (request.wish == palpate_REPLAY_ADD_BOOKMARK) ReadName(json.At("text"), request);
  return read;
}

std::string ReplayAnswer(std::uint32_t tag, std::uint64_t request, const std::string& refusal) {
  return ToText(Json({{"tag", tag}, {"request", Hex(request)}, {"refusal", refusal}}));
}

}  // namespace palpate
