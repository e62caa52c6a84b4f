#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace palpate::dds {

// The names of all topics.
// Each station has its own loop topics: over shared memory Cyclone DDS 0.10.2 ignores partitions
// and QoS when it matches, counts history depth per reader and mixes up integer keys, but it
// matches names correctly.  Each *run* has its own topics, too (SessionRequest.run pairs one
// station process with one server process: a station that meets another server_run, or whose
// session has ended, draws a new run and asks again).  So neither side's reader ever receives from
// a writer that it has not discovered, such as that of a station restarted under the same name:
// each such sample would leak a chunk for ever.
std::string PoseTopic(const std::string& station, std::uint64_t run);
std::string WrenchTopic(const std::string& station, std::uint64_t run);
/// Returns station and run of a loop topic's name; nothing if it is not one.
std::optional<std::pair<std::string, std::uint64_t>> SessionOfTopic(const std::string& topic);
inline constexpr const char* kSessionRequestTopic = "palpate/session_request";
inline constexpr const char* kSessionStateTopic = "palpate/session_state";
inline constexpr const char* kLoopWholeTopic = "palpate/loop_whole";
inline constexpr const char* kOperateRequestTopic = "palpate/operate_request";
inline constexpr const char* kWholeRequestTopic = "palpate/whole_request";
inline constexpr const char* kSceneWholeTopic = "palpate/scene_whole";
inline constexpr const char* kSolidBlockTopic = "palpate/solid_block";
inline constexpr const char* kCutLogTopic = "palpate/cut_log";
inline constexpr const char* kReplayContentsTopic = "palpate/replay_contents";
inline constexpr const char* kReplayStateTopic = "palpate/replay_state";
inline constexpr const char* kReplayRequestTopic = "palpate/replay_request";
inline constexpr const char* kGuideTopic = "palpate/guide";
inline constexpr const char* kToolStateTopic = "palpate/tool_state";
inline constexpr const char* kMovedStateTopic = "palpate/moved_state";
inline constexpr const char* kSceneOfferTopic = "palpate/scene_offer";
inline constexpr const char* kSceneBundleTopic = "palpate/scene_bundle";
inline constexpr const char* kSceneProgressTopic = "palpate/scene_progress";
inline constexpr const char* kLoopStatisticsTopic = "palpate/loop_statistics";
inline constexpr const char* kStationStatisticsTopic = "palpate/station_statistics";

/// Returns true if a station may have this name: [A-Za-z0-9_]{1,32}.
bool IsStationName(const std::string& name);

/// `--domain N` (0 to 114) names a pair of DDS domains.
inline constexpr int kMaxDomain = 114;
constexpr int LoopDomainId(int domain) {
  return 2 * domain;
}
constexpr int ServiceDomainId(int domain) {
  return 2 * domain + 1;
}
constexpr bool IsServiceDomain(int domain_id) {
  return domain_id % 2 == 1;
}

}  // namespace palpate::dds
