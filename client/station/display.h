#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "client/station/station_core.h"
#include "common/realtime/histogram.h"

namespace palpate {

/// The station's state at one moment, for display.
struct StationView {
  double seconds = 0.0;
  std::string phase;  ///< SessionLink::PhaseText
  StationSnapshot snapshot;
};

/// Prints what the station does: on a terminal a table refreshed in place, elsewhere one line at
/// a time.
class LiveTable {
 public:
  enum class Style { kInPlace, kLines, kSilent };

  /// @param colour  colours the table; lines have none.
  LiveTable(std::FILE* out, Style style, bool colour = false)
      : out_(out), style_(style), colour_(colour) {}
  /// Leaves the last table on the screen.
  ~LiveTable() = default;

  /// How often Show should be called [s].
  double period_s() const { return style_ == Style::kInPlace ? 0.25 : 1.0; }
  void Show(const StationView& view);
  /// Removes the table from the screen, so that something else can be printed; the next Show draws
  /// it below.
  void Erase();

  /// Returns one line in fixed columns: time, rate, round trip and so on.
  static std::string Line(const StationView& view);
  /// Returns the table's lines, without the codes that move the cursor.
  std::vector<std::string> Lines(const StationView& view);

 private:
  std::string Painted(const char* code, const std::string& text) const;

  std::FILE* out_;
  Style style_;
  bool colour_;
  std::size_t drawn_ = 0;  // lines on the screen
  // Full scales of the bars: they grow with the largest value seen.
  double force_scale_N_ = 1.0;
  double torque_scale_Nm_ = 0.02;
  std::vector<double> history_;  // force, newest last
};

/// Returns a bar of `width` cells, filled to value/scale in steps of an eighth of a cell.
std::string Bar(double value, double scale, int width);
/// Returns one cell per value, filled to a height of value/scale.
std::string Sparkline(const std::vector<double>& values, double scale);

/// The figures of a whole run of a station.
struct StationSummary {
  std::string station, device, scene, tool, transport;
  double seconds = 0.0;
  double linked_ticks_s = 0.0;  ///< time that the loop ran [s]: executed and missed ticks
  StationTotals totals;
  std::uint64_t missed_ticks = 0;
  int reconnects = 0;
  WrenchLimits::Bounds limits;  ///< torque zero if the device renders none
  StationSnapshot end;          ///< the last moment
};

/// Returns the summary for people.
std::string ToText(const StationSummary& summary);
/// Returns the summary for programs: one JSON object; percentile groups as in palpate-bench.
std::string ToJson(const StationSummary& summary);
/// Writes the JSON to a file, or to stdout for "-".  Throws Error.
void WriteJson(const StationSummary& summary, const std::string& file);

inline double Fraction(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

/// Returns the percentiles for people; PercentileJson is the group that every program's JSON uses.
/// @param unit  factor from [ns]; 1e-3 gives us.
std::string PercentileText(const Histogram& histogram, double unit = 1e-3, const char* name = "us");
/// @tparam Json  a JSON type of nlohmann.
template <class Json>
Json PercentileJson(const Histogram& histogram, double unit = 1e-3) {
  const auto at = [&](double q) { return unit * static_cast<double>(histogram.Quantile(q)); };
  return {{"p50", at(0.5)}, {"p99", at(0.99)}, {"p999", at(0.999)}, {"max", at(1.0)}};
}

}  // namespace palpate
