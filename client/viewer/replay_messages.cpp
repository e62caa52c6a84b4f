#include "client/viewer/replay_messages.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "client/viewer/json_text.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

/// In the order of idl/replay.idl.
constexpr std::array kWishes = {"play", "pause", "seek", "rate", "add_bookmark", "drop_bookmark"};
constexpr std::array kMarks = {"bookmark", "session", "contact", "fault", "whole"};
constexpr std::size_t kLongestText = sizeof(wire::ReplayRequest::text) - 1;  // [bytes]

std::string Hex(std::uint64_t id) {
  return fmt::format("{:x}", id);
}

/// 1 to 16 digits, as Hex writes them, and not 0.
bool ReadId(const Json& object, const char* field, std::uint64_t& id) {
  const auto found = object.find(field);
  if (found == object.end() || !found->is_string()) return false;
  const auto& text = found->get_ref<const std::string&>();
  const char* end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, id, 16);
  return error == std::errc{} && stopped == end && id != 0 && Hex(id) == text;
}

bool ReadNumber(const Json& object, const char* field, double& number) {
  const auto found = object.find(field);
  if (found == object.end() || !found->is_number()) return false;
  number = found->get<double>();
  return std::isfinite(number);
}

bool ReadTag(const Json& object, std::uint32_t& tag) {
  const auto found = object.find("tag");
  if (found == object.end() || !found->is_number_unsigned()) return false;
  const auto number = found->get<std::uint64_t>();
  tag = static_cast<std::uint32_t>(number);
  return number <= std::numeric_limits<std::uint32_t>::max();
}

/// What the wish needs besides its name; empty: nothing is missing.
const char* ReadDetails(const Json& object, wire::ReplayRequest& request) {
  const palpate_ReplayWish wish = request.wish;
  if (wish == palpate_REPLAY_PLAY || wish == palpate_REPLAY_PAUSE) return "";
  if (!ReadNumber(object, "value", request.value)) {
    return "needs for this wish a value, a finite number";
  }
  if (wish != palpate_REPLAY_ADD_BOOKMARK) return "";
  const auto text = object.find("text");
  if (text == object.end() || !text->is_string()) return "needs the bookmark's name as its text";
  const auto& name = text->get_ref<const std::string&>();
  if (name.size() > kLongestText) return "has a text of more than 120 bytes";
  // The rest of it would be cut off without a word.
  if (name.find('\0') != std::string::npos) return "has a text with a zero in it";
  wire::FromText(name, request.text);
  return "";
}

template <std::size_t N>
const char* Word(const std::array<const char*, N>& words, std::size_t i) {
  return i < N ? words[i] : "";
}

}  // namespace

std::string ToJson(const wire::ReplayContents& contents) {
  Json marks = Json::array();
  for (const wire::ReplayMark& mark : std::span(contents.marks._buffer, contents.marks._length)) {
    marks.push_back({{"at_s", mark.at_s},
                     {"number", mark.number},
                     {"kind", Word(kMarks, static_cast<std::size_t>(mark.kind))},
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

std::optional<ReplayWish> ParseReplayWish(std::string_view text, std::string& complaint) {
  const auto refuse = [&](const char* why) {
    complaint = why;
    return std::nullopt;
  };
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return refuse("is no JSON object");
  ReplayWish read;
  if (!ReadId(json, "replay", read.request.replay)) {
    return refuse("needs the replay's number as its state gives it, in hexadecimal digits");
  }
  if (!ReadTag(json, read.tag)) return refuse("needs a tag, a whole number below 2^32");
  const auto wish = json.find("wish");
  const auto found =
      wish != json.end() && wish->is_string()
          ? std::ranges::find(kWishes, std::string_view(wish->get_ref<const std::string&>()))
          : kWishes.end();
  if (found == kWishes.end()) {
    return refuse("its wish is none of play, pause, seek, rate, add_bookmark and drop_bookmark");
  }
  read.request.kind = static_cast<std::uint32_t>(found - kWishes.begin());
  read.request.wish = static_cast<palpate_ReplayWish>(read.request.kind);
  const std::string_view wrong = ReadDetails(json, read.request);
  if (!wrong.empty()) return refuse(wrong.data());
  return read;
}

std::string ReplayAnswer(std::uint32_t tag, std::uint64_t request, const std::string& refusal) {
  return ToText(Json({{"tag", tag}, {"request", Hex(request)}, {"refusal", refusal}}));
}

}  // namespace palpate
