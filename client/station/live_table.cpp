#include "client/station/live_table.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "common/step_fault.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr const char* kDim = "2";
constexpr const char* kRed = "31";
constexpr const char* kGreen = "32";
constexpr const char* kYellow = "33";
constexpr const char* kCyan = "36";
constexpr int kBarCells = 30;
constexpr std::size_t kHistoryCells = 60;  // 15 s at four a second

/// The least of 1, 2, 5, 10, 20, ... times the unit that holds the value.
double NiceScale(double value, double unit) {
  double scale = unit;
  for (int i = 0; scale < value && i < 30; ++i) scale *= i % 3 == 1 ? 2.5 : 2.0;
  return scale;
}

/// From here on the limiter may hold a peak back (MotorWarmth::kWarm).
constexpr double kHot = MotorWarmth::kWarm;

bool IsWell(const StationSnapshot& s) {
  return s.faults == 0 && !s.fading && s.warmth <= kHot;
}

std::string Ailments(const StationSnapshot& snapshot) {
  std::string words = FaultMeanings(snapshot.faults);
  if (snapshot.fading) {
    words = (snapshot.faults == 0 ? "" : words + ", ") +
            std::string("force held back (late or missing replies)");
  }
  if (snapshot.warmth > kHot) {
    words = (snapshot.faults == 0 && !snapshot.fading ? "" : words + ", ") +
            fmt::format("motors warm ({:.0f} %)", 100.0 * snapshot.warmth);
  }
  return words;
}

/// A time in microseconds, "-" where none was measured.
std::string Micros(double value, const StationSnapshot& snapshot, int decimals) {
  return snapshot.replies == 0 ? "-" : fmt::format("{:.{}f}", value, decimals);
}

}  // namespace

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
  // Written over the former table, line by line, so that nothing flickers.
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

}  // namespace palpate
