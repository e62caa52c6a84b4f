#pragma once

#include <optional>
#include <string>
#include <vector>

namespace palpate {

// Plots as SVG, for reports.  One file serves light and dark pages (prefers-color-scheme).

struct PlotAxis {
  std::string title = {};  ///< with its unit: "Step, best p99.9 [µs]"
  bool log = false;
  /// Where left out: what series and references need, rounded out.
  std::optional<double> min = {}, max = {};
};

struct PlotSeries {
  enum class Style { kLine, kPoints, kLineAndPoints };
  std::string name = {};  ///< in the legend; series of one name share colour and entry
  std::vector<double> x = {}, y = {};
  Style style = Style::kLine;
  /// Beside the points; none, or one each (empty: none there).
  std::vector<std::string> labels = {};
};

/// A threshold: a dashed line across the plot with its text beside the frame.
struct PlotReference {
  enum class Across { kHorizontal, kVertical };
  Across across = Across::kHorizontal;
  double value = 0.0;
  std::string text = {};
};

struct Plot {
  std::string title = {}, subtitle = {};
  PlotAxis x = {}, y = {};
  std::vector<PlotSeries> series = {};
  std::vector<PlotReference> references = {};
  int height = 300;  ///< of the frame [px]
};

enum class PlotTheme { kAsReader, kLight, kDark };

/// The plots one below the other.  Text never lies on text: legends stand above the frame,
/// references' texts beside it, points' labels where there is room (and are left out where there is
/// none).  On a log axis a value of 0 or less lies on the lower edge.  A line of many thousand
/// points is drawn by its extremes within each pixel.
/// Throws Error where a number is not finite, or x and y differ in size.
std::string ToSvg(const std::vector<Plot>& plots, PlotTheme theme = PlotTheme::kAsReader);

/// Throws Error where the file cannot be written.
void WriteSvg(const std::string& file, const std::vector<Plot>& plots);

}  // namespace palpate
