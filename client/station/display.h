#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "client/station/station_core.h"
#include "common/realtime/histogram.h"

namespace palpate {

/// A moment of the station, as a person sees it.
struct StationView {
  double seconds = 0.0;
  std::string phase;  ///< SessionLink::PhaseText
  StationSnapshot snapshot;
};

/// Prints what the station does: a table refreshed in place on a terminal, and a line per moment
/// elsewhere.
class LiveTable {
 public:
  enum class Style { kInPlace, kLines, kSilent };

  /// @param colour  in the table; lines have none.
  LiveTable(std::FILE* out, Style style, bool colour = false)
      : out_(out), style_(style), colour_(colour) {}
  /// Leaves the last table standing.
  ~LiveTable() = default;

  /// How often Show should be called [s].
  double period_s() const { return style_ == Style::kInPlace ? 0.25 : 1.0; }
  void Show(const StationView& view);
  /// Takes the table off the screen, so that something else can be printed; the next Show draws it
  /// below.
  void Erase();

  /// One line: time, rate, round trip and so on, in fixed columns.
  static std::string Line(const StationView& view);
  /// The table's lines, without the codes that move the cursor.
  std::vector<std::string> Lines(const StationView& view);

 private:
  std::string Painted(const char* code, const std::string& text) const;

  std::FILE* out_;
  Style style_;
  bool colour_;
  std::size_t drawn_ = 0;  // lines on the screen
  // Full scales of the bars: they grow with what was seen.
  double force_scale_N_ = 1.0;
  double torque_scale_Nm_ = 0.02;
  std::vector<double> history_;  // force, newest last
};

/// `width` cells, the first value/scale of them filled, to an eighth of a cell.
std::string Bar(double value, double scale, int width);
/// One cell per value, as high as value/scale.
std::string Sparkline(const std::vector<double>& values, double scale);

/// A station's run, at its end.
struct StationSummary {
  std::string station, device, scene, tool, transport;
  double seconds = 0.0;
  double linked_ticks_s = 0.0;  ///< time that the loop ran [s]: ticks and those it missed
  StationTotals totals;
  std::uint64_t missed_ticks = 0;
  int reconnects = 0;
  WrenchLimits::Bounds limits;  ///< torque zero where the device renders none
  StationSnapshot end;          ///< the last moment
};

/// For people.
std::string ToText(const StationSummary& summary);
/// For programs: one JSON object; percentile groups as in palpate-bench.
std::string ToJson(const StationSummary& summary);
/// Writes the JSON to a file, or to stdout for "-".  Throws Error.
void WriteJson(const StationSummary& summary, const std::string& file);

inline double Fraction(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

/// For people, and the group that every program's JSON has for a time.
/// @param unit  1e-3: in us.
std::string PercentileText(const Histogram& histogram, double unit = 1e-3, const char* name = "us");
/// @tparam Json  one of nlohmann's.
template <class Json>
Json PercentileJson(const Histogram& histogram, double unit = 1e-3) {
  const auto at = [&](double q) { return unit * static_cast<double>(histogram.Quantile(q)); };
  return {{"p50", at(0.5)}, {"p99", at(0.99)}, {"p999", at(0.999)}, {"max", at(1.0)}};
}

}  // namespace palpate
