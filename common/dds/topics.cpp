#include "common/dds/topics.h"

#include <algorithm>
#include <cinttypes>
#include <cstdio>

namespace palpate::dds {
namespace {

std::string LoopTopic(const std::string& station, std::uint64_t run, const char* what) {
  char hex[17];
  std::snprintf(hex, sizeof hex, "%016" PRIx64, run);
  return "palpate/" + station + "/" + hex + "/" + what;
}

}  // namespace

std::string PoseTopic(const std::string& station, std::uint64_t run) {
  return LoopTopic(station, run, "pose");
}

std::string WrenchTopic(const std::string& station, std::uint64_t run) {
  return LoopTopic(station, run, "wrench");
}

bool IsStationName(const std::string& name) {
  return !name.empty() && name.size() <= 32 && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
}

}  // namespace palpate::dds
