#include "client/station/display.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/files/output.h"
#include "common/step_fault.h"
#include "common/text/joined.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr const char* kDim = "2";
constexpr const char* kRed = "31";
constexpr const char* kGreen = "32";
constexpr const char* kYellow = "33";
constexpr const char* kCyan = "36";
constexpr int kBarCells = 30;
constexpr std::size_t kHistoryCells = 60;  // 15 s at four per second

/// Returns the least of 1, 2, 5, 10, 20, ... times the unit that is not below the value.
double NiceScale(double value, double unit) {
  double scale = unit;
  for (int i = 0; scale < value && i < 30; ++i) scale *= i % 3 == 1 ? 2.5 : 2.0;
  return scale;
}

/// From here on the limiter may reduce a peak (MotorWarmth::kWarm).
constexpr double kHot = MotorWarmth::kWarm;

bool IsSlow(const StationSnapshot& s) {
  return s.rate_hz < kLeastRate * s.nominal_hz;
}

bool IsWell(const StationSnapshot& s) {
  return s.faults == 0 && !s.device_at_fault && !s.fading && !IsSlow(s) && s.warmth <= kHot;
}

std::string Ailments(const StationSnapshot& s) {
  if (IsWell(s)) return FaultMeanings(0);
  std::vector<std::string> words;
  if (s.faults != 0) words.push_back(FaultMeanings(s.faults));
  if (s.device_at_fault) words.push_back("the device is at fault");
  if (IsSlow(s)) {
    words.push_back(fmt::format("the loop is slow ({:.0f} of {:.0f} Hz)", s.rate_hz, s.nominal_hz));
  }
  if (s.fading) {
    words.push_back(IsSlow(s) ? "force held back" : "force held back (late or missing replies)");
  }
  if (s.warmth > kHot) words.push_back(fmt::format("motors warm ({:.0f} %)", 100.0 * s.warmth));
  return Joined(words);
}

std::string FaultsOf(const StationTotals& t) {
  std::string words;
  if (t.device_fault_ticks == t.ticks && t.ticks > 0) {
    words = "the device was never ready";
  } else if (t.device_faults > 0) {
    words = fmt::format("the device {} time{}", t.device_faults, t.device_faults == 1 ? "" : "s");
  }
  if (words.empty()) return FaultMeanings(t.faults);
  return t.faults == 0 ? words : words + ", " + FaultMeanings(t.faults);
}

/// Returns a time in microseconds, "-" if none was measured.
std::string Micros(double value, const StationSnapshot& snapshot, int decimals) {
  return snapshot.replies == 0 ? "-" : fmt::format("{:.{}f}", value, decimals);
}

double Rate(const StationSummary& s) {
  return s.linked_ticks_s > 0.0 ? static_cast<double>(s.totals.ticks) / s.linked_ticks_s : 0.0;
}

}  // namespace

std::string PercentileText(const Histogram& histogram, double unit, const char* name) {
  if (histogram.count() == 0) return "-";
  const auto at = [&](double q) { return unit * static_cast<double>(histogram.Quantile(q)); };
  return fmt::format("p50 {:.1f}   p99 {:.1f}   p99.9 {:.1f}   max {:.1f} {}", at(0.5), at(0.99),
                     at(0.999), at(1.0), name);
}

std::string Bar(double value, double scale, int width) {
  static constexpr const char* kEighths[] = {"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
  const double share =
      scale > 0.0 && std::isfinite(value) ? std::clamp(value / scale, 0.0, 1.0) : 0.0;
  const int eighths = static_cast<int>(std::lround(share * width * 8));
  std::string bar;
  for (int i = 0; i < eighths / 8; ++i) bar += "█";
  bar += kEighths[eighths % 8];
  for (int i = (eighths + 7) / 8; i < width; ++i) bar += "·";
  return bar;
}

std::string Sparkline(const std::vector<double>& values, double scale) {
  static constexpr const char* kHeights[] = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  std::string line;
  for (double value : values) {
    const double share = scale > 0.0 ? std::clamp(value / scale, 0.0, 1.0) : 0.0;
    line += kHeights[static_cast<int>(std::ceil(share * 8))];
  }
  return line;
}

std::string LiveTable::Line(const StationView& view) {
  const StationSnapshot& s = view.snapshot;
  std::string line = fmt::format(
      "{:7.1f} s  {:5.0f} Hz  round trip {}/{} us  step {} us  contacts {}  {:6.2f} N  "
      "{:6.3f} N m  late {}  lost {}  {}",
      view.seconds, s.rate_hz, Micros(s.round_trip_us_p50, s, 0), Micros(s.round_trip_us_p99, s, 0),
      Micros(s.server_step_us_p50, s, 1), s.contacts, s.force_N, s.torque_Nm, s.late, s.lost,
      Printable(view.phase));
  if (*s.activity) line += fmt::format("  {}", s.activity);
  if (!IsWell(s)) line += "  " + Ailments(s);
  return line;
}

std::vector<std::string> LiveTable::Lines(const StationView& view) {
  const StationSnapshot& s = view.snapshot;
  force_scale_N_ = std::max(force_scale_N_, NiceScale(s.peak_force_N, 1.0));
  torque_scale_Nm_ = std::max(torque_scale_Nm_, NiceScale(s.torque_Nm, 0.01));
  history_.push_back(s.peak_force_N);
  if (history_.size() > kHistoryCells) history_.erase(history_.begin());

  const auto label = [this](const char* name) {
    return "  " + Painted(kDim, fmt::format("{:12} ", name));
  };
  const auto bar = [this](double value, double scale) {
    return Painted(kCyan, Bar(value, scale, kBarCells));
  };
  const bool well = view.phase == "active" && !s.fading;
  return {
      label("time") + fmt::format("{:7.1f} s     session  ", view.seconds) +
          Painted(well ? kGreen : kYellow, fmt::format("{:14}", Printable(view.phase))) +
          fmt::format("  hand  {}", *s.activity ? s.activity : "-"),
      label("rate") + fmt::format("{:7.0f} Hz    late {}   lost {}   fades {}   braked {}",
                                  s.rate_hz, s.late, s.lost, s.fades, s.limiter.braked),
      label("round trip") + fmt::format("{:>7} µs    p99 {} µs", Micros(s.round_trip_us_p50, s, 0),
                                        Micros(s.round_trip_us_p99, s, 0)),
      label("server step") + fmt::format("{:>7} µs", Micros(s.server_step_us_p50, s, 1)),
      label("contacts") +
          (s.replies == 0 ? fmt::format("{:>7}", "-") : fmt::format("{:7}", s.contacts)),
      label("force") + fmt::format("{:7.2f} N      ", s.force_N) + bar(s.force_N, force_scale_N_) +
          fmt::format(" {:g} N", force_scale_N_),
      label("torque") + fmt::format("{:7.3f} N m    ", s.torque_Nm) +
          bar(s.torque_Nm, torque_scale_Nm_) + fmt::format(" {:g} N m", torque_scale_Nm_),
      label("last 15 s") + Painted(kCyan, Sparkline(history_, force_scale_N_)),
      label("faults") + Painted(IsWell(s) ? kGreen : kRed, Ailments(s))};
}

std::string LiveTable::Painted(const char* code, const std::string& text) const {
  return colour_ ? std::string("\x1b[") + code + "m" + text + "\x1b[0m" : text;
}

void LiveTable::Show(const StationView& view) {
  if (style_ == Style::kSilent) return;
  if (style_ == Style::kLines) {
    std::fprintf(out_, "%s\n", Line(view).c_str());
    std::fflush(out_);
    return;
  }
  // Overwrites the former table line by line, without flicker.
  std::string text = drawn_ > 0 ? fmt::format("\x1b[{}A", drawn_) : "";
  const std::vector<std::string> lines = Lines(view);
  for (const std::string& line : lines) text += "\r" + line + "\x1b[K\n";
  drawn_ = lines.size();
  std::fputs(text.c_str(), out_);
  std::fflush(out_);
}

void LiveTable::Erase() {
  if (drawn_ == 0) return;
  std::fputs(fmt::format("\x1b[{}A\r\x1b[J", drawn_).c_str(), out_);
  std::fflush(out_);
  drawn_ = 0;
}

std::string ToText(const StationSummary& s) {
  const StationTotals& t = s.totals;
  std::string text =
      fmt::format("{:.1f} s as '{}', {}\n", s.seconds, s.station, Printable(s.device));
  text += fmt::format("  scene        {}, tool {}, over {}\n", Printable(s.scene),
                      s.tool.empty() ? "-" : Printable(s.tool), Printable(s.transport));
  text += fmt::format("  rate         {:.1f} Hz, {} poses sent, {} ticks missed\n", Rate(s), t.sent,
                      s.missed_ticks);
  text += "  round trip   " + PercentileText(t.round_trip) + "\n";
  text += "  server step  " + PercentileText(t.server_step) + "\n";
  text += fmt::format("  late         {} ({:.2f} % over 1 ms), lost {}\n", t.late,
                      100.0 * Fraction(t.late, t.replies), s.end.lost);
  text += fmt::format("  force        at most {:.2f} N, torque at most {:.3f} N m\n", t.max_force_N,
                      t.max_torque_Nm);
  text += fmt::format("  contacts     at most {}, {:.0f} % of the time in contact\n",
                      t.max_contacts, 100.0 * Fraction(t.contact_replies, t.replies));
  text += fmt::format(
      "  local model  {:.0f} % of the ticks by rows, {:.1f} % of these beyond their region\n",
      100.0 * Fraction(t.evaluations, t.ticks), 100.0 * Fraction(t.beyond_region, t.evaluations));
  text += "  faults       " + FaultsOf(t) + "\n";
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
                               {"rtt_us", PercentileJson<nlohmann::json>(t.round_trip)},
                               {"server_step_us", PercentileJson<nlohmann::json>(t.server_step)},
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
                               {"device_faults", t.device_faults},
                               {"device_fault_ticks", t.device_fault_ticks},
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
