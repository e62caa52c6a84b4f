#include "server/observation/server_metrics.h"

#include "common/dds/phase_name.h"
#include "common/realtime/wall_clock.h"
#include "common/revision.h"
#include "common/step_fault.h"

namespace palpate {
namespace {

/// Returns the names of the faults, by their bits.
const std::map<std::uint32_t, std::string>& NamedFaults() {
  static const std::map<std::uint32_t, std::string> faults = [] {
    std::map<std::uint32_t, std::string> named;
    const std::string no_name = FaultWords(1u << 31);
    for (std::uint32_t bit = 1; bit != 0; bit <<= 1) {
      if (const std::string words = FaultWords(bit); words != no_name) named[bit] = words;
    }
    return named;
  }();
  return faults;
}

}  // namespace

ServerMetrics::ServerMetrics(const dds::TransportChoice& transport, const RealtimeReport& realtime)
    : transport_(transport),
      realtime_(realtime),
      start_s_(1e-9 * static_cast<double>(WallClock_ns())) {}

void ServerMetrics::OnSession(const wire::SessionState& state) {
  const std::lock_guard lock(mutex_);
  if (state.phase == palpate_SESSION_REFUSED) {
    ++refusals_;
    return;
  }
  if (state.phase == palpate_SESSION_HELD) {
    ++held_;
    return;
  }
  const auto known = stations_.find(state.station);
  const bool is_its = known != stations_.end() && known->second.run == state.run;
  if (state.phase == palpate_SESSION_ENDED) {
    if (!is_its) return;
    ++ended_;
    stations_.erase(known);
    return;
  }
  if (!is_its) {
    ++begun_;
    stations_[state.station] = {};
  }
  Station& station = stations_[state.station];
  station.run = state.run;
  station.phase = state.phase;
  station.muted = state.muted;
}

void ServerMetrics::OnUntold(std::uint64_t refusals) {
  const std::lock_guard lock(mutex_);
  refusals_ += refusals;
}

void ServerMetrics::OnWhole(const wire::SceneWhole& whole) {
  const std::lock_guard lock(mutex_);
  ++(whole.refusal[0] == '\0' ? wholes_ : refusals_);
}

void ServerMetrics::OnStatistics(const wire::LoopStatistics& statistics) {
  const std::lock_guard lock(mutex_);
  const auto known = stations_.find(statistics.station);
  if (known == stations_.end()) return;
  Station& station = known->second;
  station.has_statistics = true;
  station.last = statistics;
  station.steps += statistics.steps;
  station.faulted += statistics.faulted_steps;
  station.late += statistics.late;
  station.lost += statistics.lost;
  station.nonfinite += statistics.rejected_nonfinite;
  station.sequence += statistics.rejected_sequence;
  station.speed += statistics.rejected_speed;
}

void ServerMetrics::FillStation(const std::string& name, const Station& station,
                                MetricsPage& page) {
  const MetricsPage::Labels labels{{"station", name}, {"scene", station.last.scene}};
  const auto with = [&](const char* label, const std::string& value) {
    MetricsPage::Labels more = labels;
    more.emplace_back(label, value);
    return more;
  };
  page.Add(metric::kServerPoseRate, station.last.rate_hz, labels);
  page.Add(metric::kServerStep, 1e-6 * station.last.step_us_p50, with("quantile", "0.5"));
  page.Add(metric::kServerStep, 1e-6 * station.last.step_us_p99, with("quantile", "0.99"));
  page.Add(metric::kServerStep, 1e-6 * station.last.step_us_p999, with("quantile", "0.999"));
  page.Add(metric::kServerStep, 1e-6 * station.last.step_us_max, with("quantile", "1"));
  page.Add(metric::kServerContacts, std::uint64_t{station.last.contacts}, labels);
  for (const auto& [bit, words] : NamedFaults()) {
    const bool has = (station.last.faults & bit) != 0;
    page.Add(metric::kServerFault, has ? 1.0 : 0.0, with("fault", words));
  }
  page.Add(metric::kServerSteps, station.steps, labels);
  page.Add(metric::kServerFaulted, station.faulted, labels);
  page.Add(metric::kServerLate, station.late, labels);
  page.Add(metric::kServerLost, station.lost, labels);
  page.Add(metric::kServerRejected, station.nonfinite, with("reason", "nonfinite"));
  page.Add(metric::kServerRejected, station.sequence, with("reason", "sequence"));
  page.Add(metric::kServerRejected, station.speed, with("reason", "speed"));
}

void ServerMetrics::Fill(MetricsPage& page) const {
  const std::lock_guard lock(mutex_);
  page.Add(metric::kServerBuild, 1.0,
           {{"version", PALPATE_VERSION}, {"physics", kPhysicsRevision}});
  const bool shm = transport_.transport == dds::Transport::kSharedMemory;
  page.Add(metric::kServerTransport, 1.0,
           {{"transport", shm ? "shm" : "udp"}, {"reason", transport_.reason}});
  page.Add(metric::kServerRealtime, realtime_.fifo ? 1.0 : 0.0, {{"grant", "fifo"}});
  page.Add(metric::kServerRealtime, realtime_.memory_locked ? 1.0 : 0.0, {{"grant", "memory"}});
  page.Add(metric::kServerRealtime, realtime_.pinned ? 1.0 : 0.0, {{"grant", "core"}});
  page.Add(metric::kServerStart, start_s_);
  page.Add(metric::kServerMemory, ResidentMemoryBytes());
  std::map<std::string, std::uint64_t> sessions;
  for (const wire::SessionPhase phase : kLivePhases) sessions[PhaseName(phase)] = 0;
  for (const auto& [name, station] : stations_) ++sessions[PhaseName(station.phase)];
  for (const auto& [phase, count] : sessions) {
    page.Add(metric::kServerSessions, count, {{"phase", phase}});
  }
  std::uint64_t muted = 0;
  for (const auto& [name, station] : stations_) muted += station.muted;
  page.Add(metric::kServerMuted, muted);
  page.Add(metric::kServerHeld, held_);
  page.Add(metric::kServerSessionsBegun, begun_);
  page.Add(metric::kServerSessionsEnded, ended_);
  page.Add(metric::kServerRefusals, refusals_);
  page.Add(metric::kServerWholes, wholes_);
  for (const auto& [name, station] : stations_) {
    if (station.has_statistics) FillStation(name, station, page);
  }
}

}  // namespace palpate
