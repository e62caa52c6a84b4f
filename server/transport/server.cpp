#include "server/transport/server.h"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <deque>
#include <functional>
#include <iterator>
#include <utility>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "common/dds/random_run.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/step_fault.h"
#include "scenes/files/scene_bundle.h"

namespace palpate {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kFrame_ns = kSecond_ns / 60;
/// Long enough for a station that asks, and for a viewer that has just joined,
/// to receive the reason.
constexpr std::int64_t kKeepEnded_ns = 5 * kSecond_ns;
constexpr int kMostRequests = 256;  // of each kind in one poll

const char* PhaseText(wire::SessionPhase phase) {
  switch (phase) {
    case palpate_SESSION_WAITING:
      return "waits for poses";
    case palpate_SESSION_ACQUIRING:
      return "starts inside an object";
    case palpate_SESSION_ACTIVE:
      return "active";
    case palpate_SESSION_REFUSED:
      return "refused";
    case palpate_SESSION_HELD:
      return "held";
    default:
      return "ended";
  }
}

const char* WishText(wire::OperateWish wish) {
  switch (wish) {
    case palpate_OPERATE_ADMIT:
      return "admit it";
    case palpate_OPERATE_TAKE_BACK:
      return "take its tool back";
    case palpate_OPERATE_MUTE:
      return "mute it";
    default:
      return "unmute it";
  }
}

const char* WholeText(const wire::SceneWhole& whole) {
  const bool is_done = whole.refusal[0] == '\0';
  switch (whole.wish) {
    case palpate_WHOLE_BOOKMARK:
      return is_done ? "bookmarked" : "not bookmarked: ";
    case palpate_WHOLE_BACK:
      return is_done ? "back at its bookmark" : "not brought back to its bookmark: ";
    default:
      return is_done ? "whole again" : "not made whole: ";
  }
}

wire::LoopStatistics MakeStatistics(const Session& session, const LoopCounters& counters,
                                    double period_s) {
  wire::LoopStatistics s{};
  wire::FromText(session.station(), s.station);
  wire::FromText(session.tool().scene, s.scene);
  s.period_s = period_s;
  s.steps = counters.steps;
  s.rate_hz = static_cast<double>(counters.poses) / period_s;
  s.step_us_p50 = 1e-3 * static_cast<double>(counters.step.Quantile(0.5));
  s.step_us_p99 = 1e-3 * static_cast<double>(counters.step.Quantile(0.99));
  s.step_us_p999 = 1e-3 * static_cast<double>(counters.step.Quantile(0.999));
  s.step_us_max = 1e-3 * static_cast<double>(counters.step.max());
  s.late = counters.late;
  s.lost = counters.lost;
  s.rejected_nonfinite = counters.rejected_nonfinite;
  s.rejected_sequence = counters.rejected_sequence;
  s.rejected_speed = counters.rejected_speed;
  s.renormalised = counters.renormalised;
  s.faulted_steps = counters.faulted_steps;
  s.contacts = session.snapshot().contacts;
  s.faults = counters.faults;
  return s;
}

std::string StatisticsLine(const wire::LoopStatistics& s) {
  char line[320];
  std::snprintf(
      line, sizeof line,
      "%-12s %-14s %7.1f Hz  step us p50 %6.1f p99 %6.1f p99.9 %6.1f max %8.1f  "
      "late %4" PRIu64 " lost %4" PRIu64 " rejected %4" PRIu64 "  contacts %" PRIu32 "  faults %s",
      s.station, s.scene, s.rate_hz, s.step_us_p50, s.step_us_p99, s.step_us_p999, s.step_us_max,
      s.late, s.lost, s.rejected_nonfinite + s.rejected_sequence + s.rejected_speed, s.contacts,
      FaultWords(s.faults).c_str());
  return line;
}

/// The strongest forces first.
void SetContactPoints(const LoopSnapshot& snapshot, wire::ToolState& state) {
  std::vector<ContactForce> contacts(snapshot.point.begin(),
                                     snapshot.point.begin() + snapshot.points);
  std::ranges::stable_sort(contacts, std::greater{},
                           [](const ContactForce& contact) { return contact.force.norm(); });
  state.points = static_cast<std::uint32_t>(std::min(contacts.size(), std::size(state.point)));
  for (std::uint32_t i = 0; i < state.points; ++i) {
    wire::FromVec3(contacts[i].point, state.point[i].position_m);
    wire::FromVec3(contacts[i].force, state.point[i].force_N);
  }
}

/// The sequence borrows the items, which must outlive it.
template <class T, class Sequence>
void PointTo(std::vector<T>& items, Sequence& sequence) {
  sequence._buffer = items.data();
  sequence._length = sequence._maximum = static_cast<std::uint32_t>(items.size());
  sequence._release = false;
}

}  // namespace

Server::Server(dds::Participant loop_domain, dds::Participant service_domain,
               std::vector<std::shared_ptr<const ServedTool>> tools,
               std::function<void(const std::string&)> print_line, bool admit_by_hand)
    : loop_domain_(std::move(loop_domain)),
      service_domain_(std::move(service_domain)),
      server_run_(RandomRun()),
      table_(std::move(tools), server_run_, admit_by_hand),
      print_line_(std::move(print_line)),
      requests_(service_domain_, dds::kSessionRequestTopic, dds::Qos::kRecordSession),
      states_(service_domain_, dds::kSessionStateTopic, dds::Qos::kSession),
      solid_blocks_(service_domain_, dds::kSolidBlockTopic, dds::Qos::kSession),
      cut_logs_(service_domain_, dds::kCutLogTopic, dds::Qos::kSession),
      loop_wholes_(service_domain_, dds::kLoopWholeTopic, dds::Qos::kSession),
      whole_requests_(service_domain_, dds::kWholeRequestTopic, dds::Qos::kRecordSession),
      operate_requests_(service_domain_, dds::kOperateRequestTopic, dds::Qos::kRecordSession),
      wholes_(service_domain_, dds::kSceneWholeTopic, dds::Qos::kSession),
      scene_bundles_(service_domain_, dds::kSceneBundleTopic, dds::Qos::kSession),
      offers_(service_domain_, dds::kSceneOfferTopic, dds::Qos::kSession),
      tool_states_(service_domain_, dds::kToolStateTopic, dds::Qos::kStream),
      moved_states_(service_domain_, dds::kMovedStateTopic, dds::Qos::kStream),
      statistics_(service_domain_, dds::kLoopStatisticsTopic, dds::Qos::kStream) {}

Server::~Server() {
  stations_.clear();
  table_.EndAll("the server stops");
  PublishChanges(0);
}

void Server::PublishScene(const std::string& name, std::vector<std::uint8_t> bundle,
                          const std::vector<std::string>& seats) {
  wire::SceneBundle sample{};
  wire::FromText(name, sample.scene);
  sample.server_run = server_run_;
  sample.hash = BundleHash(bundle);
  PointTo(bundle, sample.bundle);
  if (!scene_bundles_.Write(sample)) {
    throw Error("scene '" + name + "': DDS does not take its bundle of " +
                std::to_string(bundle.size()) + " bytes; is the memory used up?");
  }
  sample.bundle = {};
  for (const std::string& seat : seats) {
    wire::FromText(seat, sample.scene);
    if (!scene_bundles_.Write(sample)) throw Error("scene '" + seat + "': DDS does not take it");
  }
}

void Server::Offer(const std::vector<ServedScene>& scenes) {
  // The sample's sequences point to these.
  std::deque<std::vector<wire::HandKey>> hands;
  std::deque<std::vector<wire::OfferedTool>> tools;
  std::vector<wire::OfferedScene> offered;
  const auto add_hand = [&](const std::vector<PoseScript::Key>& hand, auto& sequence) {
    std::vector<wire::HandKey>& keys = hands.emplace_back();
    for (const PoseScript::Key& key : hand) {
      wire::HandKey& to = keys.emplace_back();
      to.time_s = key.t;
      wire::FromPose(key.X_WH, to.position_m, to.orientation_wxyz);
      wire::FromText(key.label, to.label);
    }
    PointTo(keys, sequence);
  };
  for (const ServedScene& scene : scenes) {
    wire::OfferedScene& to = offered.emplace_back();
    wire::FromText(scene.name, to.scene);
    wire::FromText(scene.file, to.file);
    add_hand(scene.hand, to.hand);
    std::vector<wire::OfferedTool>& its_tools = tools.emplace_back();
    for (const ServedScene::Tool& tool : scene.tools) {
      wire::OfferedTool& its = its_tools.emplace_back();
      wire::FromText(tool.served->tool, its.tool);
      wire::FromPose(tool.X_WT, its.start_position_m, its.start_orientation_wxyz);
      wire::FromText(tool.remark, its.remark);
      add_hand(tool.hand, its.hand);
    }
    PointTo(its_tools, to.tools);
  }
  wire::SceneOffer offer{};
  offer.server_run = server_run_;
  PointTo(offered, offer.scenes);
  if (!offers_.Write(offer)) {
    throw Error("DDS does not take the offer of " + std::to_string(scenes.size()) +
                " scenes; serve fewer");
  }
}

void Server::Poll(std::int64_t now_ns) {
  TakeRequests(now_ns);
  table_.Update(now_ns);
  UpdateLinks(now_ns);
  PublishChanges(now_ns);
  DisposeOfEnded(now_ns);
  CheckSharedMemory(now_ns);
  // In steps of a sixtieth; otherwise polls of 5 ms would make it fifty a second.
  const bool tool_states_due = now_ns - tool_states_ns_ >= kFrame_ns;
  if (tool_states_due) tool_states_ns_ = std::max(tool_states_ns_ + kFrame_ns, now_ns - kFrame_ns);
  for (auto& [name, station] : stations_) {
    if (tool_states_due) PublishToolState(station.link->session());
    ReportStatistics(station, now_ns);
  }
}

void Server::LogWish(std::int64_t now_ns, const std::string& line) {
  if (lines_.Take(now_ns)) {
    spdlog::info("{}", line);
  } else {
    ++lines_left_out_;
  }
}

void Server::TakeRequests(std::int64_t now_ns) {
  // No more than the readers hold, so that a flood does not block this thread.
  wire::SessionRequest request;
  for (int i = 0; i < kMostRequests && requests_.Take(request); ++i) {
    table_.Request(request, now_ns);
  }
  wire::WholeRequest whole;
  for (int i = 0; i < kMostRequests && whole_requests_.Take(whole); ++i) {
    // Each request takes the forces from all tools of the scene until they begin again.
    if (wishes_to_make_whole_.Take(now_ns)) {
      table_.Request(whole);
    } else {
      ++untold_;
    }
  }
  wire::OperateRequest operate;
  for (int i = 0; i < kMostRequests && operate_requests_.Take(operate); ++i) {
    if (!table_.Operate(operate, now_ns)) continue;
    LogWish(now_ns, fmt::format("station {}: {} asks to {}", operate.station, operate.by,
                                WishText(operate.wish)));
  }
}

void Server::UpdateLinks(std::int64_t now_ns) {
  for (auto entry = stations_.begin(); entry != stations_.end();) {
    const auto& [name, station] = *entry;
    const auto session = table_.sessions().find(name);
    const bool over =
        session == table_.sessions().end() || session->second.get() != &station.link->session();
    if (over) {
      TellUnheard(name, entry->second);
      ForgetStreams(name);
    }
    entry = over ? stations_.erase(entry) : std::next(entry);
  }
  table_.RetireEnded(now_ns);
  const auto arms = std::ranges::count_if(
      table_.sessions(), [](const auto& entry) { return !entry.second->below_arms(); });
  for (const auto& [name, session] : table_.sessions()) {
    try {
      Station& station = stations_[name];
      if (!station.link) {
        table_.Begin(*session);
        station.link = std::make_unique<StationLink>(loop_domain_, session);
      }
      station.link->Update(now_ns, arms <= 1);
    } catch (const Error& error) {
      // DDS has run out of something; the other stations go on.
      spdlog::error("station {}: {}", name, error.what());
      stations_.erase(name);
      session->End(error.what());
    }
  }
}

void Server::PublishChanges(std::int64_t now_ns) {
  for (const wire::SessionState& state : table_.TakeChanges()) {
    if (state.phase == palpate_SESSION_REFUSED || state.phase == palpate_SESSION_ENDED) {
      over_since_ns_[state.station] = now_ns;
    } else {
      over_since_ns_.erase(state.station);
    }
    LogWish(now_ns, fmt::format("station {}: {}{}{}{}", state.station, PhaseText(state.phase),
                                state.muted ? ", muted" : "", state.reason[0] != '\0' ? ": " : "",
                                state.reason));
    states_.Write(state);
    if (events_.session) events_.session(state);
  }
  // If viewers have stalled, a write waits for up to 100 ms: allow that once in a poll.
  bool taken = true;
  for (SolidBlockNews& news : table_.TakeCuts(now_ns)) {
    PointTo(news.surface, news.sample.surface);
    PointTo(news.removed_mm3, news.sample.removed_mm3);
    taken = taken && solid_blocks_.Write(news.sample);
    if (!taken) table_.TellAgain(news.sample, now_ns);
  }
  for (CutLogNews& news : table_.TakeCutLogs(now_ns)) {
    PointTo(news.events, news.sample.events);
    cut_logs_.Write(news.sample);
  }
  for (const wire::LoopWhole& whole : table_.TakeLoopWholes()) loop_wholes_.Write(whole);
  for (const wire::SceneWhole& whole : table_.TakeWholes()) {
    LogWish(now_ns, fmt::format("scene {}: {}{}, asked by {}", whole.scene, WholeText(whole),
                                whole.refusal, whole.by));
    wholes_.Write(whole);
    if (events_.whole) events_.whole(whole);
  }
}

void Server::DisposeOfEnded(std::int64_t now_ns) {
  std::erase_if(over_since_ns_, [&](const auto& entry) {
    if (now_ns - entry.second < kKeepEnded_ns) return false;
    wire::SessionState state{};
    wire::FromText(entry.first, state.station);
    states_.Dispose(state);
    return true;
  });
  const std::uint64_t untold = table_.TakeUntold();
  if (untold > 0 && events_.untold) events_.untold(untold);
  untold_ += untold;
  if (untold_ + lines_left_out_ == 0 || now_ns - untold_said_ns_ < kSecond_ns) return;
  if (untold_ > 0) {
    spdlog::warn("{} more requests were refused without a message", untold_);
  }
  if (lines_left_out_ > 0) {
    spdlog::warn("{} more lines about stations and scenes were suppressed", lines_left_out_);
  }
  untold_ = lines_left_out_ = 0;
  untold_said_ns_ = now_ns;
}

void Server::CheckSharedMemory(std::int64_t now_ns) {
  if (memory_lost_ || now_ns - memory_checked_ns_ < kSecond_ns) return;
  memory_checked_ns_ = now_ns;
  memory_lost_ = loop_domain_.shared_memory_lost();
  if (memory_lost_) {
    spdlog::warn(
        "RouDi has ended: sessions continue, new ones use UDP; for shared memory, restart RouDi, "
        "server and stations together");
  }
}

void Server::ForgetStreams(const std::string& station) {
  wire::ToolState state{};
  wire::FromText(station, state.station);
  tool_states_.Dispose(state);
  wire::LoopStatistics statistics{};
  wire::FromText(station, statistics.station);
  statistics_.Dispose(statistics);
}

void Server::PublishToolState(Session& session) {
  const LoopSnapshot& snapshot = session.snapshot();
  if (!snapshot.has_pose) return;
  wire::ToolState state{};
  wire::FromText(session.station(), state.station);
  wire::FromText(session.tool().scene, state.scene);
  wire::FromText(session.tool().tool, state.tool);
  state.pose_sequence = snapshot.pose_sequence;
  wire::FromPose(snapshot.X_WH, state.haptic_position_m, state.haptic_orientation_wxyz);
  wire::FromPose(snapshot.X_WG, state.graphic_position_m, state.graphic_orientation_wxyz);
  wire::FromVec3(snapshot.wrench.force, state.force_N);
  wire::FromVec3(snapshot.wrench.torque, state.torque_Nm);
  state.step_us = 1e6 * snapshot.step_s;
  state.contacts = snapshot.contacts;
  state.faults = snapshot.faults;
  state.buttons = snapshot.buttons;
  SetContactPoints(snapshot, state);
  if (snapshot.moved > 0) PublishMoved(session);
  tool_states_.Write(state);
}

void Server::PublishMoved(const Session& session) {
  const LoopSnapshot& snapshot = session.snapshot();
  std::vector<wire::BodyPose> poses(snapshot.moved);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    wire::FromPose(snapshot.X_moved[i], poses[i].position_m, poses[i].orientation_wxyz);
  }
  wire::MovedState state{};
  wire::FromText(session.tool().scene, state.scene);
  state.pose_sequence = snapshot.pose_sequence;
  PointTo(poses, state.moved);
  moved_states_.Write(state);
}

void Server::ReportStatistics(Station& station, std::int64_t now_ns) {
  if (!station.report_wanted) {
    if (!station.link->session().snapshot().has_pose) station.reported_ns = now_ns;
    if (now_ns - station.reported_ns < kSecond_ns) return;
    station.link->session().loop().RequestCounters();
    station.report_wanted = true;
    return;
  }
  LoopCounters counters;
  if (!station.link->session().loop().ReadCounters(counters)) return;
  const wire::LoopStatistics statistics = MakeStatistics(
      station.link->session(), counters, 1e-9 * static_cast<double>(now_ns - station.reported_ns));
  station.reported_ns = now_ns;
  station.report_wanted = false;
  statistics_.Write(statistics);
  if (events_.statistics) events_.statistics(statistics);
  TellUnheard(statistics.station, station);
  if (print_line_) print_line_(StatisticsLine(statistics));
}

void Server::TellUnheard(const std::string& name, Station& station) {
  const std::uint64_t refused = station.link->refused();
  if (refused == station.refused) return;
  spdlog::warn(
      "station {}: {} poses ignored, beyond its share of {} per second and half of the time", name,
      refused - station.refused, ServoBudget::kPosesPerSecond);
  station.refused = refused;
}

}  // namespace palpate
