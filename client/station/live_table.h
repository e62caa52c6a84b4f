#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "client/station/station_core.h"

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

}  // namespace palpate
