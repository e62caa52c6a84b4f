#include "client/station/summary.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/files/output.h"
#include "common/step_fault.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

double Microseconds(std::uint64_t ns) {
  return 1e-3 * static_cast<double>(ns);
}

double Fraction(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

double Rate(const StationSummary& s) {
  return s.linked_ticks_s > 0.0 ? static_cast<double>(s.totals.ticks) / s.linked_ticks_s : 0.0;
}

std::string Percentiles(const Histogram& histogram) {
  if (histogram.count() == 0) return "-";
  return fmt::format("p50 {:.1f}   p99 {:.1f}   p99.9 {:.1f}   max {:.1f} us",
                     Microseconds(histogram.Quantile(0.5)), Microseconds(histogram.Quantile(0.99)),
                     Microseconds(histogram.Quantile(0.999)), Microseconds(histogram.max()));
}

nlohmann::json JsonPercentiles(const Histogram& histogram) {
  return {{"p50", Microseconds(histogram.Quantile(0.5))},
          {"p99", Microseconds(histogram.Quantile(0.99))},
          {"p999", Microseconds(histogram.Quantile(0.999))},
          {"max", Microseconds(histogram.max())}};
}

}  // namespace

std::string ToText(const StationSummary& s) {
  const StationTotals& t = s.totals;
  std::string text =
      fmt::format("{:.1f} s as '{}', {}\n", s.seconds, s.station, Printable(s.device));
  text += fmt::format("  scene        {}, tool {}, over {}\n", Printable(s.scene),
                      s.tool.empty() ? "-" : Printable(s.tool), Printable(s.transport));
  text += fmt::format("  rate         {:.1f} Hz, {} poses sent, {} ticks missed\n", Rate(s), t.sent,
                      s.missed_ticks);
  text += "  round trip   " + Percentiles(t.round_trip) + "\n";
  text += "  server step  " + Percentiles(t.server_step) + "\n";
  text += fmt::format("  late         {} ({:.2f} % over 1 ms), lost {}\n", t.late,
                      100.0 * Fraction(t.late, t.replies), s.end.lost);
  text += fmt::format("  force        at most {:.2f} N, torque at most {:.3f} N m\n", t.max_force_N,
                      t.max_torque_Nm);
  text += fmt::format("  contacts     at most {}, {:.0f} % of the time in contact\n",
                      t.max_contacts, 100.0 * Fraction(t.contact_replies, t.replies));
  text += fmt::format(
      "  local model  {:.0f} % of the ticks by rows, {:.1f} % of these beyond their region\n",
      100.0 * Fraction(t.evaluations, t.ticks), 100.0 * Fraction(t.beyond_region, t.evaluations));
  text += "  faults       " + FaultMeanings(t.faults) + "\n";
  text += fmt::format(
      "  limiter      {} fades, {} clamped, {} slewed, {} braked, {} warm, "
      "{} not finite; {} reconnects\n",
      s.end.limiter.fades, s.end.limiter.clamped, s.end.limiter.slewed, s.end.limiter.braked,
      s.end.limiter.warm, s.end.limiter.nonfinite, s.reconnects);
  text += fmt::format(
      "  energy       {:.1f} mJ put in by the hand, at the lowest {:.3f}; motors {:.0f} % warm\n",
      1e3 * s.end.energy_J, 1e3 * s.end.energy_J_min, 100.0 * s.end.warmth);
  return text;
}

std::string ToJson(const StationSummary& s) {
  const StationTotals& t = s.totals;
  const nlohmann::json local_model = {
      {"ticks", t.ticks}, {"evaluations", t.evaluations}, {"beyond_region", t.beyond_region}};
  const nlohmann::json json = {{"station", s.station},
                               {"device", s.device},
                               {"scene", s.scene},
                               {"tool", s.tool},
                               {"transport", s.transport},
                               {"seconds", s.seconds},
                               {"rate_hz", Rate(s)},
                               {"poses", t.sent},
                               {"replies", t.replies},
                               {"missed_ticks", s.missed_ticks},
                               {"rtt_us", JsonPercentiles(t.round_trip)},
                               {"server_step_us", JsonPercentiles(t.server_step)},
                               {"late", t.late},
                               {"late_fraction", Fraction(t.late, t.replies)},
                               {"lost", s.end.lost},
                               {"strays", t.strays},
                               {"force_N_max", t.max_force_N},
                               {"torque_Nm_max", t.max_torque_Nm},
                               {"contacts_max", t.max_contacts},
                               {"contact_fraction", Fraction(t.contact_replies, t.replies)},
                               {"local_model", local_model},
                               {"faults", t.faults},
                               {"fault_words", FaultWords(t.faults)},
                               {"reconnects", s.reconnects},
                               {"limits",
                                {{"force_N", s.limits.force_N},
                                 {"torque_Nm", s.limits.torque_Nm},
                                 {"continuous_force_N", s.limits.continuous_force_N},
                                 {"continuous_torque_Nm", s.limits.continuous_torque_Nm}}},
                               {"limiter",
                                {{"calls", s.end.limiter.calls},
                                 {"nonfinite", s.end.limiter.nonfinite},
                                 {"clamped", s.end.limiter.clamped},
                                 {"slewed", s.end.limiter.slewed},
                                 {"braked", s.end.limiter.braked},
                                 {"warm", s.end.limiter.warm},
                                 {"faded", s.end.limiter.faded},
                                 {"fades", s.end.limiter.fades},
                                 {"disabled", s.end.limiter.disabled}}},
                               {"energy_J", s.end.energy_J},
                               {"energy_J_min", s.end.energy_J_min},
                               {"warmth", s.end.warmth}};
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

void WriteJson(const StationSummary& summary, const std::string& file) {
  WriteOutput("--json", file, ToJson(summary));
}

}  // namespace palpate
