#pragma once

#include <string>

namespace palpate::dds {

// Every topic's name, in one place.
// Loop topics are per station: over shared memory Cyclone DDS 0.10.2 matches neither partitions nor
// QoS, counts history depth per reader and mixes up integer keys; names are what it gets right.
inline std::string PoseTopic(const std::string& station) { return "palpate/" + station + "/pose"; }
inline std::string WrenchTopic(const std::string& station) {
  return "palpate/" + station + "/wrench";
}
inline constexpr const char* kSessionRequestTopic = "palpate/session_request";
inline constexpr const char* kSessionStateTopic = "palpate/session_state";
inline constexpr const char* kToolStateTopic = "palpate/tool_state";
inline constexpr const char* kLoopStatisticsTopic = "palpate/loop_statistics";

/// `--domain N` (0 to 114) names a pair of DDS domains.
inline constexpr int kMaxDomain = 114;
inline int LoopDomainId(int domain) { return 2 * domain; }
inline int ServiceDomainId(int domain) { return 2 * domain + 1; }

}  // namespace palpate::dds
