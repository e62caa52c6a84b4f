#pragma once

namespace palpate {

/// A metric after the conventions of Prometheus: base units, and "_total" for counters.
struct Metric {
  enum class Kind { kGauge, kCounter };
  Kind kind;
  const char* name;
  const char* help;
};

// All metrics that programs of this project expose.  A station's metrics have the labels `station`
// and `scene`, and exist as long as its session.
namespace metric {

inline constexpr Metric kServerBuild{Metric::Kind::kGauge, "palpate_server_build_info",
                                     "1; its version as a label"};
inline constexpr Metric kServerTransport{
    Metric::Kind::kGauge, "palpate_server_transport_info",
    "1; how poses and wrenches travel, shm or udp, and why, as labels"};
inline constexpr Metric kServerRealtime{
    Metric::Kind::kGauge, "palpate_server_realtime",
    "1 where the servo loops have the grant: scheduling, locked memory, a core of their own"};
inline constexpr Metric kServerStart{Metric::Kind::kGauge, "palpate_server_start_time_seconds",
                                     "When the server started, since 1970"};
inline constexpr Metric kServerMemory{Metric::Kind::kGauge, "palpate_server_resident_memory_bytes",
                                      "Memory that the server has at hand"};
inline constexpr Metric kServerSessions{Metric::Kind::kGauge, "palpate_server_sessions",
                                        "Sessions that have not ended, by their phase"};
inline constexpr Metric kServerMuted{Metric::Kind::kGauge, "palpate_server_muted_sessions",
                                     "Of those, sessions whose station renders no force by order"};
inline constexpr Metric kServerHeld{Metric::Kind::kCounter, "palpate_server_held_requests_total",
                                    "Requests that wait, or waited, for somebody to admit them"};
inline constexpr Metric kServerSessionsBegun{
    Metric::Kind::kCounter, "palpate_server_sessions_begun_total", "Sessions that were accepted"};
inline constexpr Metric kServerSessionsEnded{Metric::Kind::kCounter,
                                             "palpate_server_sessions_ended_total",
                                             "Sessions that have ended, for whatever reason"};
inline constexpr Metric kServerRefusals{Metric::Kind::kCounter, "palpate_server_refusals_total",
                                        "Requests that were refused: for a session, or to make a "
                                        "scene whole"};
inline constexpr Metric kServerWholes{Metric::Kind::kCounter,
                                      "palpate_server_scenes_made_whole_total",
                                      "Times that a scene was made whole again"};
inline constexpr Metric kServerPoseRate{Metric::Kind::kGauge, "palpate_server_pose_rate_hertz",
                                        "Poses of a station in the last second"};
inline constexpr Metric kServerStep{
    Metric::Kind::kGauge, "palpate_server_step_seconds",
    "From a pose's arrival to its answer in the last second; quantile 1 is the longest"};
inline constexpr Metric kServerContacts{Metric::Kind::kGauge, "palpate_server_contacts",
                                        "Contacts that a station's tool has now"};
inline constexpr Metric kServerFault{Metric::Kind::kGauge, "palpate_server_fault",
                                     "1 for each fault that a station had in the last second"};
inline constexpr Metric kServerSteps{Metric::Kind::kCounter, "palpate_server_steps_total",
                                     "Steps of a station's servo loop"};
inline constexpr Metric kServerFaulted{Metric::Kind::kCounter, "palpate_server_faulted_steps_total",
                                       "Of those, steps with any fault"};
inline constexpr Metric kServerLate{Metric::Kind::kCounter, "palpate_server_late_poses_total",
                                    "Poses that came more than 2 ms after the one before"};
inline constexpr Metric kServerLost{Metric::Kind::kCounter, "palpate_server_lost_poses_total",
                                    "Poses that never came, by the gaps in their numbers"};
inline constexpr Metric kServerRejected{
    Metric::Kind::kCounter, "palpate_server_rejected_poses_total",
    "Poses that came and were not used, by reason: nonfinite, sequence or speed"};

inline constexpr Metric kGatewayBuild{Metric::Kind::kGauge, "palpate_gateway_build_info",
                                      "1; its version as a label"};
inline constexpr Metric kGatewayMemory{Metric::Kind::kGauge,
                                       "palpate_gateway_resident_memory_bytes",
                                       "Memory that the gateway has at hand"};
inline constexpr Metric kGatewayViewers{Metric::Kind::kGauge, "palpate_gateway_viewers",
                                        "Viewers that are attached"};
inline constexpr Metric kGatewayViewersLimit{Metric::Kind::kGauge, "palpate_gateway_viewers_limit",
                                             "Viewers that are let in at most"};
inline constexpr Metric kGatewayMice{Metric::Kind::kGauge, "palpate_gateway_mice",
                                     "Tools that viewers drive with the mouse"};
inline constexpr Metric kGatewayStations{Metric::Kind::kGauge, "palpate_gateway_stations",
                                         "Stations that the gateway hears of"};
inline constexpr Metric kGatewayScenes{Metric::Kind::kGauge, "palpate_gateway_scenes",
                                       "Scenes that the gateway has for viewers"};
inline constexpr Metric kGatewayIn{Metric::Kind::kCounter, "palpate_gateway_frames_received_total",
                                   "Messages of servers and stations that were taken in"};
inline constexpr Metric kGatewayOut{Metric::Kind::kCounter, "palpate_gateway_frames_sent_total",
                                    "Messages that were sent to viewers"};
inline constexpr Metric kGatewayDropped{Metric::Kind::kCounter,
                                        "palpate_gateway_frames_dropped_total",
                                        "Messages that a slow viewer missed: newer ones took their "
                                        "place"};
inline constexpr Metric kGatewayBytes{Metric::Kind::kCounter, "palpate_gateway_sent_bytes_total",
                                      "Bytes of the messages that were sent to viewers"};
inline constexpr Metric kGatewayRefusals{Metric::Kind::kCounter, "palpate_gateway_refusals_total",
                                         "Viewers that were not let in"};

}  // namespace metric
}  // namespace palpate
