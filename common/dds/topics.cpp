#include "common/dds/topics.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "common/text/hex16.h"

namespace palpate::dds {
namespace {

std::string LoopTopic(const std::string& station, std::uint64_t run, const char* what) {
  return "palpate/" + station + "/" + Hex16(run) + "/" + what;
}

}  // namespace

std::string PoseTopic(const std::string& station, std::uint64_t run) {
  return LoopTopic(station, run, "pose");
}

std::string WrenchTopic(const std::string& station, std::uint64_t run) {
  return LoopTopic(station, run, "wrench");
}

std::optional<std::pair<std::string, std::uint64_t>> SessionOfTopic(const std::string& topic) {
  constexpr std::string_view kBegin = "palpate/";
  constexpr std::size_t kDigits = 16;
  const std::size_t run_at = topic.rfind('/', topic.rfind('/') - 1) + 1;
  if (!topic.starts_with(kBegin) || run_at <= kBegin.size()) return std::nullopt;
  const std::string station = topic.substr(kBegin.size(), run_at - 1 - kBegin.size());
  std::uint64_t run = 0;
  const char* const digits = topic.data() + run_at;
  const auto [end, problem] = std::from_chars(digits, topic.data() + topic.size(), run, 16);
  const std::string_view what(end, topic.data() + topic.size());
  if (problem != std::errc() || end != digits + kDigits || !IsStationName(station) ||
      (what != "/pose" && what != "/wrench")) {
    return std::nullopt;
  }
  return std::pair(station, run);
}

bool IsStationName(const std::string& name) {
  return !name.empty() && name.size() <= 32 && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
}

}  // namespace palpate::dds
