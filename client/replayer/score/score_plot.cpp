#include "client/replayer/score/score_plot.h"

#include <algorithm>
#include <cmath>

#include <spdlog/fmt/fmt.h>

#include "client/replayer/score/score_words.h"

namespace palpate {
namespace {

// In pixels.
constexpr double kWidth = 960.0, kHeight = 300.0;  // of the picture; of one plot's frame
constexpr double kLeft = 78.0, kRight = kWidth - 26.0;
constexpr double kFont = 13.0, kLine = 18.0;

constexpr std::size_t kColours = 8;  // --series-1 to --series-8 of the palette

constexpr const char* kCss =
    "svg{font-family:var(--font)}.paper{fill:var(--paper)}.ink{fill:var(--ink)}.quiet{fill:var(--"
    "quiet)}.bold{font-weight:600}.grid{stroke:var(--line)}.frame{stroke:var(--quiet);fill:none}."
    "curve{fill:none;stroke-width:1.6;stroke-linejoin:round}\n";

/// Returns the approximate width in a sans-serif font, rather too large than too small.
double WidthOf(const std::string& text) {
  const auto letters = std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; });
  return 0.58 * kFont * static_cast<double>(letters);
}

std::string Text(double x, double y, const char* classes, const char* anchor,
                 const std::string& text, double font = kFont) {
  return fmt::format(
      "<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"{}\" text-anchor=\"{}\" "
      "font-size=\"{}\"{}>{}</text>\n",
      x, y, classes, anchor, font, KeyAttribute(text), Escaped(InEnglish(text)));
}

std::string Curve(std::size_t line, const std::string& points) {
  return fmt::format(
      "<polyline points=\"{}\" class=\"curve\" style=\"stroke:var(--series-{})\"/>\n", points,
      line % kColours + 1);
}

/// An axis from 0 to a round number that is not below any value.
class Scale {
 public:
  /// @param from, to  positions of 0 and of the end [px]
  Scale(double greatest, double from, double to) : from_(from), to_(to) {
    const double raw = (greatest > 0.0 ? greatest : 1.0) / (std::abs(to - from) / 70.0);
    const double decade = std::pow(10.0, std::floor(std::log10(raw)));
    step_ = 10.0 * decade;
    for (const double m : {5.0, 2.0, 1.0}) {
      if (m * decade >= raw) step_ = m * decade;
    }
    steps_ = std::max(1, static_cast<int>(std::ceil(greatest / step_ - 1e-9)));
  }
  double At(double value) const { return from_ + value / (step_ * steps_) * (to_ - from_); }
  std::vector<double> ticks() const {
    std::vector<double> ticks;
    for (int i = 0; i <= steps_; ++i) ticks.push_back(i * step_);
    return ticks;
  }

 private:
  double from_, to_, step_;
  int steps_;
};

/// Appends one plot below `top`; returns where it ends.
double Draw(const ScorePlot& plot, double top, std::string& svg) {
  double y = top + 24.0;
  svg += Text(16, y, "ink bold", "start", plot.title, 16);
  svg += Text(16, y += 20.0, "quiet", "start", plot.subtitle);
  double x = kLeft;
  y += kLine + 4.0;
  for (std::size_t i = 0; i < plot.lines.size(); ++i) {  // legend
    const double width = 42.0 + WidthOf(plot.lines[i].name);
    if (x > kLeft && x + width > kRight) x = kLeft, y += kLine;
    svg += Curve(i, fmt::format("{:.1f},{:.1f} {:.1f},{:.1f}", x, y - 4.5, x + 20.0, y - 4.5));
    svg += Text(x + 26.0, y, "ink", "start", plot.lines[i].name);
    x += width;
  }

  double greatest_x = 0.0, greatest_y = 0.0;
  for (const ScorePlot::Line& line : plot.lines) {
    for (const double v : line.x) greatest_x = std::max(greatest_x, v);
    for (const double v : line.y) greatest_y = std::max(greatest_y, v);
  }
  const double above = y + 14.0, below = above + kHeight;
  const Scale sx(greatest_x, kLeft, kRight), sy(greatest_y, below, above);
  const auto grid = [&](double x0, double y0, double x1, double y1) {
    svg += fmt::format(
        "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"grid\"/>\n", x0, y0,
        x1, y1);
  };
  for (const double tick : sy.ticks()) {
    grid(kLeft, sy.At(tick), kRight, sy.At(tick));
    svg += Text(kLeft - 8.0, sy.At(tick) + 4.5, "quiet", "end", fmt::format("{:.6g}", tick));
  }
  for (const double tick : sx.ticks()) {
    grid(sx.At(tick), above, sx.At(tick), below);
    svg += Text(sx.At(tick), below + 18.0, "quiet", "middle", fmt::format("{:.6g}", tick));
  }
  svg += Text(0.5 * (kLeft + kRight), below + 38.0, "ink", "middle", plot.x_title);
  svg += fmt::format(
      "<text transform=\"rotate(-90 18 {0:.1f})\" x=\"18\" y=\"{0:.1f}\" class=\"ink\" "
      "text-anchor=\"middle\" font-size=\"{1}\"{2}>{3}</text>\n",
      0.5 * (above + below), kFont, KeyAttribute(plot.y_title), Escaped(InEnglish(plot.y_title)));
  for (std::size_t i = 0; i < plot.lines.size(); ++i) {
    const ScorePlot::Line& line = plot.lines[i];
    std::string points;
    for (std::size_t k = 0; k < line.x.size(); ++k) {
      points += fmt::format("{:.1f},{:.1f} ", sx.At(line.x[k]), sy.At(line.y[k]));
    }
    svg += Curve(i, points);
  }
  svg += fmt::format("<rect x=\"{}\" y=\"{:.1f}\" width=\"{}\" height=\"{}\" class=\"frame\"/>\n",
                     kLeft, above, kRight - kLeft, kHeight);
  return below + 56.0;
}

}  // namespace

std::string ToSvg(const std::vector<ScorePlot>& plots) {
  std::string body;
  double bottom = 0.0;
  for (const ScorePlot& plot : plots) bottom = Draw(plot, bottom, body);
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1:.0f}\" width=\"{0}\" "
      "height=\"{1:.0f}\">\n<style>{2}{3}</style>\n<rect width=\"100%\" height=\"100%\" "
      "class=\"paper\"/>\n{4}</svg>\n",
      kWidth, bottom, kScorePagePalette, kCss, body);
}

}  // namespace palpate
