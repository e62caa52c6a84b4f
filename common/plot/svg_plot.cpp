#include "common/plot/svg_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr double kWidth = 960.0, kLeft = 78.0, kFont = 13.0, kLine = 18.0, kPointRadius = 4.5;

struct Colours {
  const char *paper, *ink, *faint, *grid;
  std::array<const char*, 8> series;
};
// Told apart by the colour-blind as well, and by the marks' shapes.
constexpr Colours kLightColours{
    "#ffffff",
    "#1f2328",
    "#59636e",
    "#d8dee4",
    {"#0969da", "#bc4c00", "#1a7f37", "#8250df", "#9a6700", "#bf3989", "#0e7490", "#57606a"}};
constexpr Colours kDarkColours{
    "#0d1117",
    "#e6edf3",
    "#9198a1",
    "#30363d",
    {"#58a6ff", "#ff9b5e", "#56d364", "#d2a8ff", "#e3b341", "#ff80bf", "#56d4dd", "#afb8c1"}};

std::string Css(const Colours& c) {
  std::string css = fmt::format(
      ".paper{{fill:{0}}}.ink{{fill:{1}}}.faint{{fill:{2}}}.grid{{stroke:{3}}}"
      ".frame{{stroke:{2}}}.ref{{stroke:{2}}}.halo{{stroke:{0}}}\n",
      c.paper, c.ink, c.faint, c.grid);
  for (std::size_t i = 0; i < c.series.size(); ++i) {
    css += fmt::format(".l{0}{{stroke:{1}}}.p{0}{{fill:{1}}}", i, c.series[i]);
  }
  return css + "\n";
}

/// Text as XML, which has no control characters, and is UTF-8.
std::string Escape(const std::string& text) {
  std::string out;
  for (const char c : Printable(text)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

/// About what a sans-serif takes; a little more rather than less.
double WidthOf(const std::string& text, double font = kFont) {
  const auto letters =
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; });
  return 0.58 * font * static_cast<double>(letters);
}

struct Box {
  double x0, y0, x1, y1;
  bool Meets(const Box& b) const { return x0 < b.x1 && b.x0 < x1 && y0 < b.y1 && b.y0 < y1; }
};

/// One axis: its range, its ticks, and where a value lies between `from` and `to` [px].
class Scale {
 public:
  Scale(const PlotAxis& axis, double low, double high, double least_positive, double from,
        double to)
      : log_(axis.log), from_(from), to_(to) {
    if (log_) {
      if (!(least_positive > 0.0) || !std::isfinite(least_positive)) least_positive = 1.0;
      low = axis.min.value_or(least_positive);
      high = std::max(axis.max.value_or(high), 1.0001 * low);
      if (!(low > 0.0)) throw Error("plot: log axis '" + axis.title + "' begins at 0; set its min");
      Logarithmic(low, high, axis);
    } else {
      low = axis.min.value_or(low);
      high = axis.max.value_or(high);
      if (!(low < high)) {
        const double room = low == 0.0 ? 1.0 : 0.1 * std::abs(low);
        low -= axis.min ? 0.0 : room;
        high = low + 2.0 * room;
      }
      Linear(low, high, axis);
    }
  }

  double At(double value) const {
    const double share = log_ ? (value > low_ ? std::log(value / low_) / std::log(high_ / low_) : 0)
                              : (value - low_) / (high_ - low_);
    return from_ + share * (to_ - from_);
  }
  bool Holds(double value) const {
    const double rounding = 1e-9 * (high_ - low_);
    return value >= low_ - rounding && value <= high_ + rounding;
  }
  const std::vector<double>& ticks() const { return ticks_; }
  std::string Text(double tick) const {
    if (tick != 0.0 && log_ && (tick >= 1e6 || tick < 1e-4)) return fmt::format("{:.0e}", tick);
    return fmt::format("{:.6g}", std::abs(tick) < 1e-12 * (high_ - low_) ? 0.0 : tick);
  }

 private:
  void Linear(double low, double high, const PlotAxis& axis) {
    const double raw = (high - low) / std::clamp(std::abs(to_ - from_) / 70.0, 3.0, 12.0);
    const double decade = std::pow(10.0, std::floor(std::log10(raw)));
    double step = 10.0 * decade;
    for (const double m : {5.0, 2.5, 2.0, 1.0}) {
      if (m * decade >= raw) step = m * decade;
    }
    low_ = axis.min ? low : step * std::floor(low / step + 1e-9);
    high_ = axis.max ? high : step * std::ceil(high / step - 1e-9);
    for (double k = std::ceil(low_ / step - 1e-9); k * step <= high_ + 1e-9 * step; ++k) {
      ticks_.push_back(k * step);
    }
  }

  void Logarithmic(double low, double high, const PlotAxis& axis) {
    const double decades = std::log10(high / low);
    const auto steps = decades > 4.0   ? std::vector<double>{1.0}
                       : decades > 2.0 ? std::vector<double>{1.0, 3.0}
                                       : std::vector<double>{1.0, 2.0, 5.0};
    std::vector<double> grid;
    for (int e = -18; e <= 18; ++e) {
      for (const double s : steps) grid.push_back(s * std::pow(10.0, e));
    }
    low_ = low;
    high_ = high;
    for (const double g : grid) {
      if (!axis.min && g <= low * (1 + 1e-9)) low_ = g;
      if (!axis.max && g >= high * (1 - 1e-9)) {
        high_ = g;
        break;
      }
    }
    for (const double g : grid) {
      if (Holds(g)) ticks_.push_back(g);
    }
  }

  bool log_;
  double from_, to_;
  double low_ = 0.0, high_ = 1.0;
  std::vector<double> ticks_;
};

class Writer {
 public:
  void Text(double x, double y, const char* classes, const char* anchor, const std::string& text,
            double font = kFont) {
    out += fmt::format(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"{}\" text-anchor=\"{}\" font-size=\"{}\">{}"
        "</text>\n",
        x, y, classes, anchor, font, Escape(text));
  }
  void Line(double x0, double y0, double x1, double y1, const std::string& classes,
            const char* more = "") {
    out += fmt::format(
        "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"{}\"{}/>\n", x0, y0,
        x1, y1, classes, more);
  }
  /// A mark whose shape goes with the series, so that colour is not all that tells them apart.
  void Mark(std::size_t series, double x, double y) {
    const double r = kPointRadius;
    const std::string classes = fmt::format("p{} halo", series % 8);
    switch (series % 4) {
      case 0:
        out += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" class=\"{}\"/>\n", x, y, r,
                           classes);
        return;
      case 1:
        Polygon(classes, {{x - r, y - r}, {x + r, y - r}, {x + r, y + r}, {x - r, y + r}});
        return;
      case 2:
        Polygon(classes, {{x, y - 1.2 * r}, {x + 1.2 * r, y + r}, {x - 1.2 * r, y + r}});
        return;
      default:
        Polygon(classes, {{x, y - 1.3 * r}, {x + 1.3 * r, y}, {x, y + 1.3 * r}, {x - 1.3 * r, y}});
    }
  }

  std::string out;

 private:
  void Polygon(const std::string& classes, std::initializer_list<std::array<double, 2>> corners) {
    out += "<polygon points=\"";
    for (const auto& [x, y] : corners) out += fmt::format("{:.1f},{:.1f} ", x, y);
    out += fmt::format("\" class=\"{}\"/>\n", classes);
  }
};

/// Points of a line in pixels; of those that share a pixel column only the extremes, in order.
std::vector<std::array<double, 2>> Thinned(const std::vector<std::array<double, 2>>& points) {
  if (points.size() < 4000) return points;
  std::vector<std::array<double, 2>> kept;
  for (std::size_t i = 0; i < points.size();) {
    std::size_t end = i + 1, low = i, high = i;
    for (; end < points.size() && std::floor(points[end][0]) == std::floor(points[i][0]); ++end) {
      if (points[end][1] < points[low][1]) low = end;
      if (points[end][1] > points[high][1]) high = end;
    }
    kept.push_back(points[std::min(low, high)]);
    if (low != high) kept.push_back(points[std::max(low, high)]);
    i = end;
  }
  return kept;
}

void Check(const Plot& plot) {
  const auto finite = [](double v) { return std::isfinite(v); };
  for (const PlotAxis* axis : {&plot.x, &plot.y}) {
    if (!finite(axis->min.value_or(0.0)) || !finite(axis->max.value_or(0.0))) {
      throw Error("plot '" + plot.title + "': an axis ends at no finite number");
    }
  }
  for (const PlotReference& reference : plot.references) {
    if (!finite(reference.value)) {
      throw Error("plot '" + plot.title + "': a reference is not finite");
    }
  }
  for (const PlotSeries& series : plot.series) {
    const std::string where = "plot '" + plot.title + "', series '" + series.name + "': ";
    if (series.x.size() != series.y.size()) throw Error(where + "x and y differ in size");
    if (!series.labels.empty() && series.labels.size() != series.x.size()) {
      throw Error(where + "give no label or one for each point");
    }
    if (!std::all_of(series.x.begin(), series.x.end(), finite) ||
        !std::all_of(series.y.begin(), series.y.end(), finite)) {
      throw Error(where + "has values that are not finite");
    }
  }
}

Scale MakeScale(const Plot& plot, bool horizontal, double from, double to) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double low = kInfinity, high = -kInfinity, positive = kInfinity;
  const auto add = [&](double v) {
    low = std::min(low, v);
    high = std::max(high, v);
    if (v > 0.0) positive = std::min(positive, v);
  };
  for (const PlotSeries& s : plot.series) {
    for (const double v : horizontal ? s.x : s.y) add(v);
  }
  for (const PlotReference& r : plot.references) {
    if ((r.across == PlotReference::Across::kVertical) == horizontal) add(r.value);
  }
  if (low > high) add(0.0), add(1.0);
  return Scale(horizontal ? plot.x : plot.y, low, high, positive, from, to);
}

/// Index of each series' colour: by its name, in order of appearance.
std::vector<std::size_t> ColourOf(const Plot& plot, std::vector<std::string>& names) {
  std::vector<std::size_t> colour;
  for (const PlotSeries& s : plot.series) {
    const auto at = std::find(names.begin(), names.end(), s.name);
    colour.push_back(static_cast<std::size_t>(at - names.begin()));
    if (at == names.end()) names.push_back(s.name);
  }
  return colour;
}

/// Draws one plot below `top`; returns where it ends.
double Draw(const Plot& plot, int number, double top, Writer& svg) {
  Check(plot);
  double y = top + 24.0;
  if (!plot.title.empty()) svg.Text(16, y, "ink bold", "start", plot.title, 16), y += 20.0;
  if (!plot.subtitle.empty()) svg.Text(16, y, "faint", "start", plot.subtitle), y += kLine;

  std::vector<std::string> names;
  const std::vector<std::size_t> colour = ColourOf(plot, names);
  double x = kLeft;
  y += 4.0;
  for (std::size_t n = 0; n < names.size(); ++n) {  // legend
    if (names[n].empty()) continue;
    const double width = 34.0 + WidthOf(names[n]);
    if (x > kLeft && x + width > kWidth - 12.0) x = kLeft, y += kLine;
    bool line = false, points = false;
    for (std::size_t s = 0; s < colour.size(); ++s) {
      if (colour[s] != n) continue;
      line |= plot.series[s].style != PlotSeries::Style::kPoints;
      points |= plot.series[s].style != PlotSeries::Style::kLine;
    }
    if (line) svg.Line(x, y - 4.5, x + 20.0, y - 4.5, fmt::format("l{} curve", n % 8));
    if (points) svg.Mark(n, x + 10.0, y - 4.5);
    svg.Text(x + 26.0, y, "ink", "start", names[n]);
    x += width + 8.0;
  }

  // Texts of vertical references stand in rows above the frame; those of horizontal ones right.
  double right = 26.0;
  for (const PlotReference& r : plot.references) {
    if (r.across == PlotReference::Across::kHorizontal) {
      right = std::max(right, WidthOf(r.text, 12) + 18.0);
    }
  }
  const Scale sx = MakeScale(plot, true, kLeft, kWidth - right);
  std::vector<double> row_end;
  std::vector<std::pair<const PlotReference*, std::size_t>> above;
  std::vector<const PlotReference*> vertical, horizontal;
  for (const PlotReference& r : plot.references) {
    const bool v = r.across == PlotReference::Across::kVertical;
    if (v && sx.Holds(r.value)) vertical.push_back(&r);
    if (!v) horizontal.push_back(&r);
  }
  const auto by_value = [](const PlotReference* a, const PlotReference* b) {
    return a->value < b->value;
  };
  std::sort(vertical.begin(), vertical.end(), by_value);
  std::sort(horizontal.begin(), horizontal.end(), by_value);
  const auto left_of = [&](const PlotReference& r) {
    return std::clamp(sx.At(r.value) - 0.5 * WidthOf(r.text, 12), 8.0,
                      std::max(8.0, kWidth - 8.0 - WidthOf(r.text, 12)));
  };
  for (const PlotReference* r : vertical) {
    std::size_t row = 0;
    while (row < row_end.size() && row_end[row] > left_of(*r)) ++row;
    if (row == row_end.size()) row_end.push_back(0.0);
    row_end[row] = left_of(*r) + WidthOf(r->text, 12) + 10.0;
    above.emplace_back(r, row);
  }
  const double frame_top = y + 14.0 + 16.0 * static_cast<double>(row_end.size());
  const double frame_bottom = frame_top + plot.height;
  const Scale sy = MakeScale(plot, false, frame_bottom, frame_top);

  for (const double tick : sy.ticks()) {
    svg.Line(kLeft, sy.At(tick), kWidth - right, sy.At(tick), "grid");
    svg.Text(kLeft - 8.0, sy.At(tick) + 4.5, "faint", "end", sy.Text(tick), 12);
  }
  double free = 0.0;
  for (const double tick : sx.ticks()) {
    svg.Line(sx.At(tick), frame_top, sx.At(tick), frame_bottom, "grid");
    const double half = 0.5 * WidthOf(sx.Text(tick), 12);
    if (sx.At(tick) - half < free) continue;
    free = sx.At(tick) + half + 8.0;
    svg.Text(sx.At(tick), frame_bottom + 18.0, "faint", "middle", sx.Text(tick), 12);
  }
  svg.Text(0.5 * (kLeft + kWidth - right), frame_bottom + 40.0, "ink", "middle", plot.x.title);
  svg.out += fmt::format(
      "<text transform=\"translate(20 {:.1f}) rotate(-90)\" class=\"ink\" text-anchor=\"middle\" "
      "font-size=\"13\">{}</text>\n",
      0.5 * (frame_top + frame_bottom), Escape(plot.y.title));

  for (const auto& [r, row] : above) {
    const double at = sx.At(r->value);
    const double base = frame_top - 6.0 - 16.0 * static_cast<double>(row);
    svg.Line(at, base + 3.0, at, frame_bottom, "ref");
    svg.Text(left_of(*r), base, "faint", "start", r->text, 12);
  }
  double lowest = frame_bottom + 20.0;  // texts go upwards, 15 px apart at least
  for (const PlotReference* r : horizontal) {
    if (!sy.Holds(r->value)) continue;
    const double at = sy.At(r->value), base = std::min(at + 4.0, lowest - 15.0);
    lowest = base;
    svg.Line(kLeft, at, kWidth - right, at, "ref");
    svg.Line(kWidth - right, at, kWidth - right + 8.0, base - 4.0, "ref");
    svg.Text(kWidth - right + 11.0, base, "faint", "start", r->text, 12);
  }

  svg.out += fmt::format(
      "<clipPath id=\"frame{0}\"><rect x=\"{1}\" y=\"{2:.1f}\" width=\"{3:.1f}\" height=\"{4}\"/>"
      "</clipPath>\n<g clip-path=\"url(#frame{0})\">\n",
      number, kLeft, frame_top - 1.0, kWidth - right - kLeft, plot.height + 2);
  std::vector<Box> taken;
  const auto pixel = [&](const PlotSeries& s, std::size_t i) {
    return std::array<double, 2>{sx.At(s.x[i]), sy.At(s.y[i])};
  };
  for (std::size_t n = 0; n < plot.series.size(); ++n) {
    const PlotSeries& s = plot.series[n];
    if (s.style == PlotSeries::Style::kPoints) continue;
    std::vector<std::array<double, 2>> points;
    for (std::size_t i = 0; i < s.x.size(); ++i) points.push_back(pixel(s, i));
    svg.out += "<polyline points=\"";
    for (const auto& [px, py] : Thinned(points)) svg.out += fmt::format("{:.1f},{:.1f} ", px, py);
    svg.out += fmt::format("\" class=\"l{} curve\"/>\n", colour[n] % 8);
  }
  svg.out += "</g>\n";
  svg.out += fmt::format(
      "<rect x=\"{}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{}\" class=\"frame\" "
      "fill=\"none\"/>\n",
      kLeft, frame_top, kWidth - right - kLeft, plot.height);
  for (std::size_t n = 0; n < plot.series.size(); ++n) {
    const PlotSeries& s = plot.series[n];
    if (s.style == PlotSeries::Style::kLine) continue;
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      const auto [px, py] = pixel(s, i);
      if (px < kLeft - 1 || px > kWidth - right + 1 || py < frame_top - 1 ||
          py > frame_bottom + 1) {
        continue;
      }
      svg.Mark(colour[n], px, py);
      taken.push_back({px - 6.0, py - 6.0, px + 6.0, py + 6.0});
    }
  }
  for (std::size_t n = 0; n < plot.series.size(); ++n) {
    const PlotSeries& s = plot.series[n];
    for (std::size_t i = 0; i < s.labels.size(); ++i) {
      if (s.labels[i].empty()) continue;
      const auto [px, py] = pixel(s, i);
      const double w = WidthOf(s.labels[i], 11.5), h = 12.0;
      const std::array<double, 2> corners[] = {
          {px + 8, py - 0.5 * h},   {px - 8 - w, py - 0.5 * h}, {px - 0.5 * w, py - 8 - h},
          {px - 0.5 * w, py + 8},   {px + 7, py - 7 - h},       {px + 7, py + 7},
          {px - 7 - w, py - 7 - h}, {px - 7 - w, py + 7}};
      for (const auto& [bx, by] : corners) {
        const Box box{bx, by, bx + w, by + h};
        if (box.x0 < kLeft || box.x1 > kWidth - right || box.y0 < frame_top ||
            box.y1 > frame_bottom ||
            std::any_of(taken.begin(), taken.end(), [&](const Box& b) { return b.Meets(box); })) {
          continue;
        }
        taken.push_back(box);
        svg.Text(bx, by + h - 2.5, "ink halo label", "start", s.labels[i], 11.5);
        break;
      }
    }
  }
  return frame_bottom + 56.0;
}

}  // namespace

std::string ToSvg(const std::vector<Plot>& plots, PlotTheme theme) {
  Writer body;
  double bottom = 0.0;
  for (std::size_t i = 0; i < plots.size(); ++i) {
    bottom = Draw(plots[i], static_cast<int>(i), bottom, body);
  }
  std::string css =
      ".curve{fill:none;stroke-width:1.6;stroke-linejoin:round}.grid{stroke-width:1}"
      ".frame{stroke-width:1}.ref{stroke-width:1.2;stroke-dasharray:6 4}.halo{stroke-width:1}"
      ".bold{font-weight:600}.label{paint-order:stroke;stroke-width:3}\n";
  css += Css(theme == PlotTheme::kDark ? kDarkColours : kLightColours);
  if (theme == PlotTheme::kAsReader) {
    css += "@media (prefers-color-scheme: dark){" + Css(kDarkColours) + "}\n";
  }
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1:.0f}\" width=\"{0}\" "
      "height=\"{1:.0f}\" font-family=\"system-ui, 'DejaVu Sans', Helvetica, Arial, "
      "sans-serif\">\n<style>{2}</style>\n<rect width=\"100%\" height=\"100%\" "
      "class=\"paper\"/>\n{3}</svg>\n",
      kWidth, bottom, css, body.out);
}

void WriteSvg(const std::string& file, const std::vector<Plot>& plots) {
  std::ofstream out(file);
  out << ToSvg(plots);
  out.close();
  if (!out) throw Error(file + ": cannot be written; give a file in a folder you may write");
}

}  // namespace palpate
