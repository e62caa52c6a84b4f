#include "client/station/live_table.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>

#include "common/step_fault.h"

namespace palpate {
namespace {

constexpr int kBarCells = 30;
constexpr std::size_t kHistoryCells = 60;  // 15 s at four a second

[[gnu::format(printf, 1, 2)]] std::string Text(const char* format, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

/// The least of 1, 2, 5, 10, 20, ... times the unit that holds the value.
double NiceScale(double value, double unit) {
  double scale = unit;
  for (int i = 0; scale < value && i < 30; ++i) scale *= i % 3 == 1 ? 2.5 : 2.0;
  return scale;
}

std::string FaultsAndFading(const StationSnapshot& snapshot) {
  std::string words = FaultWords(snapshot.faults);
  if (snapshot.fading) {
    words =
        (snapshot.faults == 0 ? "" : words + ", ") + std::string("force held back (late replies)");
  }
  return words;
}

/// A time in microseconds, "-" where none was measured.
std::string Microseconds(double value, const StationSnapshot& snapshot, int decimals) {
  return snapshot.replies == 0 ? "-" : Text("%.*f", decimals, value);
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
  std::string line = Text(
      "%7.1f s  %5.0f Hz  round trip %s/%s us  step %s us  %2u contacts  %6.2f N  %6.3f N m  late "
      "%llu  lost %llu  %s",
      view.seconds, s.rate_hz, Microseconds(s.round_trip_us_p50, s, 0).c_str(),
      Microseconds(s.round_trip_us_p99, s, 0).c_str(),
      Microseconds(s.server_step_us_p50, s, 1).c_str(), s.contacts, s.force_N, s.torque_Nm,
      static_cast<unsigned long long>(s.late), static_cast<unsigned long long>(s.lost),
      view.phase.c_str());
  if (*s.activity) line += Text("  %s", s.activity);
  if (s.faults != 0 || s.fading) line += "  " + FaultsAndFading(s);
  return line;
}

std::vector<std::string> LiveTable::Lines(const StationView& view) {
  const StationSnapshot& s = view.snapshot;
  force_scale_N_ = std::max(force_scale_N_, NiceScale(s.peak_force_N, 1.0));
  torque_scale_Nm_ = std::max(torque_scale_Nm_, NiceScale(s.torque_Nm, 0.01));
  history_.push_back(s.peak_force_N);
  if (history_.size() > kHistoryCells) history_.erase(history_.begin());

  std::vector<std::string> lines;
  lines.push_back(Text("  %-12s %7.1f s     session  %-14s  hand  %s", "time", view.seconds,
                       view.phase.c_str(), *s.activity ? s.activity : "-"));
  lines.push_back(Text("  %-12s %7.0f Hz    late %llu   lost %llu   fades %llu", "rate", s.rate_hz,
                       static_cast<unsigned long long>(s.late),
                       static_cast<unsigned long long>(s.lost),
                       static_cast<unsigned long long>(s.fades)));
  lines.push_back(Text("  %-12s %7s µs    p99 %s µs", "round trip",
                       Microseconds(s.round_trip_us_p50, s, 0).c_str(),
                       Microseconds(s.round_trip_us_p99, s, 0).c_str()));
  lines.push_back(Text("  %-12s %7s µs    %u contact%s", "server step",
                       Microseconds(s.server_step_us_p50, s, 1).c_str(), s.contacts,
                       s.contacts == 1 ? "" : "s"));
  lines.push_back(Text("  %-12s %7.2f N     ", "force", s.force_N) +
                  Bar(s.force_N, force_scale_N_, kBarCells) + Text(" %g N", force_scale_N_));
  lines.push_back(Text("  %-12s %7.3f N m   ", "torque", s.torque_Nm) +
                  Bar(s.torque_Nm, torque_scale_Nm_, kBarCells) +
                  Text(" %g N m", torque_scale_Nm_));
  lines.push_back(Text("  %-12s ", "last 15 s") + Sparkline(history_, force_scale_N_));
  lines.push_back(Text("  %-12s %s", "faults", FaultsAndFading(s).c_str()));
  return lines;
}

void LiveTable::Show(const StationView& view) {
  if (style_ == Style::kSilent) return;
  if (style_ == Style::kLines) {
    std::fprintf(out_, "%s\n", Line(view).c_str());
    std::fflush(out_);
    return;
  }
  // Written over the former table, line by line, so that nothing flickers.
  std::string text = drawn_ > 0 ? Text("\x1b[%zuA", drawn_) : "";
  const std::vector<std::string> lines = Lines(view);
  for (const std::string& line : lines) text += "\r" + line + "\x1b[K\n";
  drawn_ = lines.size();
  std::fputs(text.c_str(), out_);
  std::fflush(out_);
}

void LiveTable::Erase() {
  if (drawn_ == 0) return;
  std::fputs(Text("\x1b[%zuA\r\x1b[J", drawn_).c_str(), out_);
  std::fflush(out_);
  drawn_ = 0;
}

}  // namespace palpate
