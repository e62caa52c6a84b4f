#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>

#include "common/dds/participant.h"
#include "common/dds/wire.h"
#include "common/metrics/metrics_page.h"
#include "common/program/realtime.h"

namespace palpate {

/// A server's metrics, computed from what it publishes; the servo loops report nothing beyond the
/// statistics.
/// Thread contract: On... from the service thread, Fill from any.
class ServerMetrics {
 public:
  ServerMetrics(const dds::TransportChoice& transport, const RealtimeReport& realtime);

  void OnSession(const wire::SessionState& state);
  void OnUntold(std::uint64_t refusals);
  void OnWhole(const wire::SceneWhole& whole);
  void OnStatistics(const wire::LoopStatistics& statistics);

  void Fill(MetricsPage& page) const;

 private:
  struct Station {
    std::uint64_t run = 0;
    wire::SessionPhase phase{};
    bool muted = false;
    bool has_statistics = false;
    wire::LoopStatistics last{};  // of the last second
    // Totals since the session began.
    std::uint64_t steps = 0, faulted = 0, late = 0, lost = 0;
    std::uint64_t nonfinite = 0, sequence = 0, speed = 0;
  };

  static void FillStation(const std::string& name, const Station& station, MetricsPage& page);

  const dds::TransportChoice transport_;
  const RealtimeReport realtime_;
  const double start_s_;
  mutable std::mutex mutex_;
  std::map<std::string, Station> stations_;  // by name; those that have a session
  std::uint64_t begun_ = 0, ended_ = 0, held_ = 0, refusals_ = 0, wholes_ = 0;
};

}  // namespace palpate
