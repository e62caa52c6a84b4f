#include "client/python/live/live_session.h"

#include <algorithm>
#include <chrono>
#include <exception>

#include "client/python/live/live_station.h"
#include "common/dds/phase_name.h"
#include "common/dds/topics.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPoll{2};
constexpr std::chrono::milliseconds kLook{2};
/// As many stations as a server admits; further names, from unknown senders, are not stored.
constexpr std::size_t kMostStations = 32;
/// A minute of a full server's tool states, and of one station's loop.
constexpr std::size_t kMostTools = 60 * 60 * kMostStations / 4;
constexpr std::size_t kMostWrenches = 60'000;

double SteadySeconds() {
  return 1e-9 * static_cast<double>(SteadyNanoseconds());
}

void CopyPose(const double (&p)[3], const double (&wxyz)[4], double (&row)[7]) {
  std::copy_n(p, 3, row);
  std::copy_n(wxyz, 4, row + 3);
}

ToolRecord ToRecord(const wire::ToolState& state) {
  ToolRecord record{};
  record.time_s = SteadySeconds();
  wire::FromText(state.station, record.station);
  wire::FromText(state.scene, record.scene);
  wire::FromText(state.tool, record.tool_name);
  record.pose_sequence = state.pose_sequence;
  CopyPose(state.haptic_position_m, state.haptic_orientation_wxyz, record.hand);
  CopyPose(state.graphic_position_m, state.graphic_orientation_wxyz, record.tool);
  std::copy_n(state.force_N, 3, record.force_N);
  std::copy_n(state.torque_Nm, 3, record.torque_Nm);
  record.step_time_s = 1e-6 * state.step_us;
  record.contacts = state.contacts;
  record.faults = state.faults;
  record.points = std::min<std::uint32_t>(state.points, 16);
  for (std::uint32_t i = 0; i < record.points; ++i) {
    std::copy_n(state.point[i].position_m, 3, record.point[i]);
    std::copy_n(state.point[i].force_N, 3, record.point[i] + 3);
  }
  return record;
}

WrenchRecord ToRecord(const wire::Wrench& wrench) {
  WrenchRecord record{};
  record.time_s = SteadySeconds();
  record.pose_time_s = 1e-9 * static_cast<double>(wrench.pose_time_ns);
  record.pose_sequence = wrench.pose_sequence;
  record.answer = wrench.answer;
  std::copy_n(wrench.force_N, 3, record.force_N);
  std::copy_n(wrench.torque_Nm, 3, record.torque_Nm);
  CopyPose(wrench.graphic_position_m, wrench.graphic_orientation_wxyz, record.tool);
  record.step_time_s = wrench.step_time_s;
  record.contacts = wrench.contacts;
  record.faults = wrench.faults;
  return record;
}

dds::Participant MakeService(const LiveSessionOptions& options) {
  const std::lock_guard lock(MakingParticipants());
  return dds::Participant::Service(options.domain, options.network);
}

std::optional<dds::Participant> MakeLoop(const LiveSessionOptions& options) {
  if (!options.wrenches) return std::nullopt;
  const std::lock_guard lock(MakingParticipants());
  return dds::Participant::Loop(
      options.domain, dds::ChooseTransport(options.transport, options.network), options.network);
}

}  // namespace

LiveSession::LiveSession(const LiveSessionOptions& options)
    : options_(options),
      service_(MakeService(options)),
      loop_(MakeLoop(options)),
      states_(service_, dds::kSessionStateTopic, dds::Qos::kRecordSession),
      tools_(service_, dds::kToolStateTopic, dds::Qos::kRecord),
      thread_([this] { Run(); }) {}

void LiveSession::Run() {
  try {
    while (!stop_.load()) {
      {
        const std::lock_guard lock(mutex_);
        for (wire::SessionState state; states_.Take(state);) {
          heard_ = true;
          const std::string name = state.station;
          if (!dds::IsStationName(name)) continue;
          if (!stations_.contains(name) && stations_.size() == kMostStations) {
            // Stations that have gone make room.
            std::erase_if(stations_, [](const auto& entry) { return entry.second.over; });
            if (stations_.size() == kMostStations) continue;
          }
          Station& station = stations_[name];
          station.phase = PhaseName(state.phase);
          station.run = state.run;
          station.over = IsOver(state);
        }
        for (wire::ToolState state; tools_.Take(state);) {
          const auto station = stations_.find(state.station);
          const ToolRecord record = ToRecord(state);
          if (station != stations_.end()) station->second.latest_tool = record;
          queue_.push_back(record);
          if (queue_.size() > kMostTools) {
            queue_.pop_front();
            ++dropped_;
          }
        }
      }
      if (loop_) OpenWrenches();
      std::this_thread::sleep_for(kPoll);
    }
  } catch (const std::exception& error) {
    const std::lock_guard lock(mutex_);
    error_ = error.what();
  }
  // Cleared without the lock: a reader's end waits for its callbacks.
  taps_.clear();
}

void LiveSession::OpenWrenches() {
  std::map<std::string, std::uint64_t> runs;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [name, station] : stations_) {
      if (!station.over) runs[name] = station.run;
    }
  }
  std::erase_if(taps_, [&](const auto& entry) { return !runs.contains(entry.first); });
  for (const auto& [name, run] : runs) {
    Tap& tap = taps_[name];
    if (tap.run != run) tap = {run, {}};
    const std::string topic = dds::WrenchTopic(name, run);
    // Over shared memory, a reader made before it has discovered the writer leaks chunks for good.
    if (tap.reader || !dds::WriterDiscovered(*loop_, topic)) continue;
    tap.reader = {*loop_, topic, dds::Qos::kRecord,
                  [this, name = name](const wire::Wrench& wrench) {
                    const WrenchRecord record = ToRecord(wrench);
                    const std::lock_guard lock(mutex_);
                    const auto station = stations_.find(name);
                    if (station == stations_.end()) return;
                    station->second.latest_wrench = record;
                    station->second.wrenches.push_back(record);
                    if (station->second.wrenches.size() > kMostWrenches) {
                      station->second.wrenches.pop_front();
                      ++dropped_;
                    }
                  }};
  }
}

std::string LiveSession::WhySilent() const {
  if (!error_.empty()) return error_;
  if (states_.matched_writers() == 0) {
    return heard_ ? "the server has gone: " + NobodyAnswers(options_.domain, options_.network, "")
                  : NobodyAnswers(options_.domain, options_.network, "");
  }
  const bool any = std::any_of(stations_.begin(), stations_.end(),
                               [](const auto& entry) { return !entry.second.over; });
  return any ? "the server has fallen silent; it may have died, or hang"
             : "no station is in a session; start a palpate-station, or a palpate.live.Station";
}

/// @param queue_of  returns the queue; null: none yet.   @param why  says why nothing came.
template <class Record, class QueueOf, class Why>
std::vector<Record> LiveSession::Take(double patience_s, const WaitOrStop& wait, QueueOf queue_of,
                                      Why why) {
  const double until = SteadySeconds() + patience_s;
  for (;;) {
    {
      const std::lock_guard lock(mutex_);
      if (std::deque<Record>* const queue = queue_of(); queue != nullptr && !queue->empty()) {
        std::vector<Record> taken(queue->begin(), queue->end());
        queue->clear();
        return taken;
      }
      if (stop_.load()) throw Error("the session is closed");
      if (SteadySeconds() > until) throw Silence(why());
    }
    wait(kLook);
  }
}

std::vector<ToolRecord> LiveSession::TakeTools(double patience_s, const WaitOrStop& wait) {
  return Take<ToolRecord>(
      patience_s, wait, [this] { return &queue_; },
      [this] { return "no tool's state came: " + WhySilent(); });
}

std::vector<WrenchRecord> LiveSession::TakeWrenches(const std::string& name, double patience_s,
                                                    const WaitOrStop& wait) {
  if (!options_.wrenches) {
    throw Error("wrenches: the session was opened without them; give Session(wrenches=True)");
  }
  const auto queue_of = [&] {
    const auto station = stations_.find(name);
    return station == stations_.end() ? nullptr : &station->second.wrenches;
  };
  return Take<WrenchRecord>(patience_s, wait, queue_of, [&] {
    const Station* const station = Find(name);
    return "no wrench of station '" + name + "' came: " +
           (station != nullptr && !station->over ? "its session is " + station->phase
            : states_.matched_writers() == 0     ? WhySilent()
                                                 : "it is in no session here");
  });
}

/// Call it with the lock held.
const LiveSession::Station* LiveSession::Find(const std::string& name) const {
  const auto station = stations_.find(name);
  return station == stations_.end() ? nullptr : &station->second;
}

std::optional<ToolRecord> LiveSession::LatestTool(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const Station* const station = Find(name);
  return station != nullptr ? station->latest_tool : std::nullopt;
}

std::optional<WrenchRecord> LiveSession::LatestWrench(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const Station* const station = Find(name);
  return station != nullptr ? station->latest_wrench : std::nullopt;
}

std::map<std::string, std::string> LiveSession::phases() const {
  const std::lock_guard lock(mutex_);
  std::map<std::string, std::string> phases;
  for (const auto& [name, station] : stations_) phases[name] = station.phase;
  return phases;
}

std::uint64_t LiveSession::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

void LiveSession::Close() {
  stop_.store(true);
  if (thread_.joinable()) thread_.join();
}

}  // namespace palpate
