#include "client/station/statistics_period.h"

#include <algorithm>

namespace palpate {
namespace {

/// Returns the growth of a count whose totals may have been restarted (StationCore::RestartTotals).
unsigned long long Grown(std::uint64_t now, std::uint64_t before) {
  return now >= before ? now - before : now;
}

}  // namespace

StatisticsPeriod::StatisticsPeriod(const std::string& station, const std::string& device) {
  wire::FromText(station, figures_.station);
  wire::FromText(device, figures_.device);
}

std::optional<wire::StationStatistics> StatisticsPeriod::Add(const StationSnapshot& s,
                                                             std::uint64_t missed_ticks,
                                                             std::uint64_t run, bool last) {
  wire::StationStatistics& f = figures_;
  f.ticks += s.ticks;
  f.replies += s.replies;
  f.silence_s_max = std::max(f.silence_s_max, s.silence_s_max);
  f.wanted_force_N_max = std::max(f.wanted_force_N_max, s.wanted_force_N_max);
  f.wanted_torque_Nm_max = std::max(f.wanted_torque_Nm_max, s.wanted_torque_Nm_max);
  f.applied_force_N_max = std::max(f.applied_force_N_max, s.peak_force_N);
  f.applied_torque_Nm_max = std::max(f.applied_torque_Nm_max, s.peak_torque_Nm);
  f.device_status |= s.status;
  if (began_ns_ == 0) {
    // The first snapshot counts too; its period began that many ticks earlier.
    const double period_s = s.rate_hz > 0.0 ? static_cast<double>(s.ticks) / s.rate_hz : 0.0;
    began_ns_ = s.time_ns - static_cast<std::int64_t>(1e9 * period_s);
  }
  // Tolerates half a snapshot period: four quarters of a second make one second.
  if (!last && s.time_ns - began_ns_ < kPeriod_ns - 100'000'000) return std::nullopt;

  f.run = run;
  f.period_s = 1e-9 * static_cast<double>(s.time_ns - began_ns_);
  f.missed_ticks = Grown(missed_ticks, missed_before_);
  f.sent = Grown(s.sent, before_.sent);
  f.late = Grown(s.late, before_.late);
  f.lost = Grown(s.lost, before_.lost);
  const LimiterCounts &now = s.limiter, &then = before_.limiter;
  f.nonfinite = now.nonfinite - then.nonfinite;
  f.clamped = now.clamped - then.clamped;
  f.slewed = now.slewed - then.slewed;
  f.braked = now.braked - then.braked;
  f.warm = now.warm - then.warm;
  f.faded = now.faded - then.faded;
  f.fades = now.fades - then.fades;
  f.disabled = now.disabled - then.disabled;
  f.energy_J = s.energy_J;
  f.energy_J_min = s.energy_J_min;
  f.warmth = s.warmth;

  const wire::StationStatistics whole = f;
  began_ns_ = s.time_ns;
  before_ = s;
  missed_before_ = missed_ticks;
  f.ticks = f.replies = 0;
  f.silence_s_max = f.wanted_force_N_max = f.wanted_torque_Nm_max = 0.0;
  f.applied_force_N_max = f.applied_torque_Nm_max = 0.0;
  f.device_status = 0;
  return whole;
}

}  // namespace palpate
