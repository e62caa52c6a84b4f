#include "client/load/load_figures.h"

#include <algorithm>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "client/station/display.h"
#include "common/step_fault.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMost = 0.01;  // largest share of late poses, and of lost frames
constexpr double kToMs = 1e-6;

std::string CpuText(const std::optional<double>& use) {
  return use ? fmt::format("{:.2f}", *use) : "-";
}

Json CpuJson(const std::optional<double>& use) {
  return use ? Json(*use) : Json(nullptr);
}

}  // namespace

void StationSum::Add(const StationTotals& totals, std::uint64_t missed, int reconnected) {
  // The last pose's reply has no further tick to take it.
  const std::uint64_t ticks = totals.ticks + missed;
  const std::uint64_t its_due = ticks > 0 ? ticks - 1 : 0;
  const std::uint64_t its_answered = std::min(totals.replies, its_due);
  const std::uint64_t its_on_time = its_answered - std::min(totals.late, its_answered);
  due += its_due;
  answered += its_answered;
  on_time += its_on_time;
  missed_ticks += missed;
  reconnects += static_cast<std::uint64_t>(reconnected);
  faults |= totals.faults;
  round_trip.Add(totals.round_trip);
  server_step.Add(totals.server_step);
  const double its_hz = 1000.0 * Fraction(its_answered, its_due);
  worst_hz = stations_ == 0 ? its_hz : std::min(worst_hz, its_hz);
  worst_late_fraction = std::max(worst_late_fraction, Fraction(its_due - its_on_time, its_due));
  ++stations_;
}

double StationSum::late_fraction() const {
  return Fraction(due - on_time, due);
}

double StationSum::hz() const {
  return 1000.0 * Fraction(answered, due);
}

double LoadFigures::lost_fraction() const {
  return Fraction(lost, frames_due);
}

bool Holds(const LoadFigures& f) {
  return f.sum.late_fraction() < kMost && f.lost_fraction() < kMost && f.viewers_gone == 0;
}

std::string VerdictText(const LoadFigures& f) {
  std::string because;
  const auto add = [&](const std::string& reason) {
    because += (because.empty() ? "" : "; ") + reason;
  };
  const double most = 100.0 * kMost;
  if (f.sum.late_fraction() >= kMost) {
    add(fmt::format("{:.3f} % of the poses were late, and {:g} % is too much",
                    100.0 * f.sum.late_fraction(), most));
  }
  if (f.lost_fraction() >= kMost) {
    add(fmt::format("{:.2f} % of the frames were lost, and {:g} % is too much",
                    100.0 * f.lost_fraction(), most));
  }
  if (f.viewers_gone > 0) add(fmt::format("{} viewers are gone", f.viewers_gone));
  return because.empty() ? "holds" : "does not hold, because " + because;
}

std::string ToText(const LoadFigures& f) {
  std::string text =
      fmt::format("{} stations, {} viewers, {:.1f} s\n", f.stations, f.viewers, f.seconds);
  if (f.stations > 0) {
    text += fmt::format("  rate         {:.1f} Hz, worst station {:.1f} Hz, over {}\n", f.sum.hz(),
                        f.sum.worst_hz, f.transport);
    text += fmt::format("  late         {:.3f} %, worst station {:.3f} %; {} ticks missed",
                        100.0 * f.sum.late_fraction(), 100.0 * f.sum.worst_late_fraction,
                        f.sum.missed_ticks);
    text += f.sum.reconnects > 0 ? fmt::format(", {} reconnects\n", f.sum.reconnects) : "\n";
    text += "  round trip   " + PercentileText(f.sum.round_trip) + "\n";
    text += "  server step  " + PercentileText(f.sum.server_step) + "\n";
    if (f.sum.faults != 0) text += "  faults       " + FaultMeanings(f.sum.faults) + "\n";
  }
  if (f.viewers > 0) {
    text += fmt::format(
        "  frames       {} ({:.1f} a second and viewer), {} lost, {} viewers gone\n",
        f.viewer_frames,
        static_cast<double>(f.viewer_frames) / f.seconds / static_cast<double>(f.viewers), f.lost,
        f.viewers_gone);
    text += "  frame age    " + PercentileText(f.frame_age, kToMs, "ms") + "\n";
  }
  text += fmt::format(
      "  cores used   server {}, gateway {}, this program {:.2f}; machine {:.0f} % busy\n",
      CpuText(f.server), CpuText(f.gateway), f.self, 100.0 * f.machine_busy);
  return text + VerdictText(f) + "\n";
}

std::string ToJson(const LoadFigures& f) {
  const Json json = {{"stations", f.stations},
                     {"viewers", f.viewers},
                     {"seconds", f.seconds},
                     {"holds", Holds(f)},
                     {"transport", f.transport},
                     {"achieved_hz", f.sum.hz()},
                     {"achieved_hz_worst", f.sum.worst_hz},
                     {"late_fraction", f.sum.late_fraction()},
                     {"late_fraction_worst", f.sum.worst_late_fraction},
                     {"missed_ticks", f.sum.missed_ticks},
                     {"reconnects", f.sum.reconnects},
                     {"faults", f.sum.faults},
                     {"rtt_us", PercentileJson<Json>(f.sum.round_trip)},
                     {"server_step_us", PercentileJson<Json>(f.sum.server_step)},
                     {"server_cpu_fraction", CpuJson(f.server)},
                     {"gateway_cpu_fraction", CpuJson(f.gateway)},
                     {"load_cpu_fraction", f.self},
                     {"machine_busy_fraction", f.machine_busy},
                     {"load_averages_before", f.load_averages},
                     {"viewer_frames", f.viewer_frames},
                     {"frames_due", f.frames_due},
                     {"lost", f.lost},
                     {"viewers_gone", f.viewers_gone},
                     {"frame_age_ms", PercentileJson<Json>(f.frame_age, kToMs)}};
  return json.dump(2) + "\n";
}

}  // namespace palpate
