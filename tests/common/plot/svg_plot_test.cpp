#include "common/plot/svg_plot.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/complaint.h"

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::Not;

struct Text {
  double x0, y0, x1, y1;
  std::string words;
};

/// Upright texts of a drawing with the room that DejaVu Sans, a wide face, takes.
std::vector<Text> TextsOf(const std::string& svg) {
  static const std::regex kText(
      R"re(<text x="([-.0-9]+)" y="([-.0-9]+)" class="[^"]*" text-anchor="(\w+)" font-size="([.0-9]+)">([^<]*)<)re");
  std::vector<Text> texts;
  for (std::sregex_iterator m(svg.begin(), svg.end(), kText), end; m != end; ++m) {
    const double x = std::stod((*m)[1]), y = std::stod((*m)[2]), font = std::stod((*m)[4]);
    const double w = 0.55 * font * static_cast<double>((*m)[5].length());
    const double x0 = (*m)[3] == "start" ? x : (*m)[3] == "end" ? x - w : x - 0.5 * w;
    texts.push_back({x0, y - 0.75 * font, x0 + w, y, (*m)[5]});
  }
  return texts;
}

Plot Crowded() {
  Plot plot{.title = "Crowded",
            .subtitle = "many labels & references",
            .x = {.title = "time [us]", .log = true},
            .y = {.title = "error", .log = true}};
  for (int s = 0; s < 9; ++s) {
    PlotSeries series{.name = "series number " + std::to_string(s),
                      .style = PlotSeries::Style::kLineAndPoints};
    for (int i = 0; i < 6; ++i) {
      series.x.push_back(1.0 + s + 0.3 * i);
      series.y.push_back(1e-3 * (1 + i) * (1 + s % 3));
      series.labels.push_back("point " + std::to_string(10 * s + i));
    }
    plot.series.push_back(series);
  }
  for (const double v : {0.005, 0.0052, 0.06, 0.08}) {
    plot.references.push_back({PlotReference::Across::kHorizontal, v, "threshold of a fingertip"});
    plot.references.push_back(
        {PlotReference::Across::kVertical, 1000 * v, "the chapter's longest step"});
  }
  return plot;
}

TEST(SvgPlot, NeverWritesTextOnText) {
  const std::vector<Text> texts = TextsOf(ToSvg({Crowded(), Crowded()}));
  ASSERT_GT(texts.size(), 80u);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    EXPECT_GE(texts[i].x0, 0.0) << texts[i].words;
    EXPECT_LE(texts[i].x1, 960.0) << texts[i].words;
    for (std::size_t j = 0; j < i; ++j) {
      const Text &a = texts[i], &b = texts[j];
      EXPECT_FALSE(a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1)
          << "'" << a.words << "' lies on '" << b.words << "'";
    }
  }
}

TEST(SvgPlot, EscapesWhatXmlReserves) {
  Plot plot{.title = "a < b & \"c\" > d", .series = {{.name = "<&>", .x = {0, 1}, .y = {0, 1}}}};
  const std::string svg = ToSvg({plot});
  EXPECT_THAT(svg, HasSubstr("a &lt; b &amp; &quot;c&quot; &gt; d"));
  EXPECT_THAT(svg, HasSubstr("&lt;&amp;&gt;"));
}

TEST(SvgPlot, PlacesValuesByTheirLogarithmAndNothingOnTheLowerEdge) {
  Plot plot{.x = {.title = "x", .log = true, .min = 1.0, .max = 100.0},
            .y = {.title = "y", .min = 0.0, .max = 1.0},
            .series = {{.name = "s",
                        .x = {1, 10, 100, 0},
                        .y = {0.5, 0.5, 0.5, 0.5},
                        .style = PlotSeries::Style::kPoints}}};
  const std::string svg = ToSvg({plot});
  static const std::regex kCircle(R"re(<circle cx="([.0-9]+)" cy="([.0-9]+)")re");
  std::vector<double> x;
  for (std::sregex_iterator m(svg.begin(), svg.end(), kCircle), end; m != end; ++m) {
    x.push_back(std::stod((*m)[1]));
  }
  ASSERT_EQ(x.size(), 5u);  // one of them in the legend
  EXPECT_NEAR(x[2] - x[1], x[3] - x[2], 0.15);
  EXPECT_EQ(x[4], x[1]);
}

TEST(SvgPlot, KeepsTheExtremesOfLongLines) {
  PlotSeries noise{.name = "noise"};
  for (int i = 0; i < 100000; ++i) {
    noise.x.push_back(i);
    noise.y.push_back(i == 54321 ? 1.0 : 0.0);
  }
  const std::string svg =
      ToSvg({Plot{.y = {.title = "y", .min = 0.0, .max = 1.0}, .series = {noise}}});
  EXPECT_LT(svg.size(), 60000u);
  const std::string peak = ToSvg({Plot{.y = {.title = "y", .min = 0.0, .max = 1.0},
                                       .series = {{.name = "noise", .x = {0}, .y = {1.0}}}}});
  const std::string points = peak.substr(peak.find("<polyline points=\"") + 18, 20);
  const std::string top = points.substr(points.find(','), points.find(' ') - points.find(','));
  EXPECT_THAT(svg, HasSubstr(top + " "));
}

TEST(SvgPlot, FollowsTheReadersThemeUnlessOneIsAskedFor) {
  const std::vector<Plot> plots{Crowded()};
  EXPECT_THAT(ToSvg(plots), HasSubstr("prefers-color-scheme: dark"));
  EXPECT_THAT(ToSvg(plots, PlotTheme::kDark), Not(HasSubstr("prefers-color-scheme")));
  EXPECT_NE(ToSvg(plots, PlotTheme::kDark), ToSvg(plots, PlotTheme::kLight));
}

TEST(SvgPlot, RefusesWhatCannotBeDrawnAndNamesIt) {
  const auto message = [](const Plot& plot) { return test::ComplaintOf([&] { ToSvg({plot}); }); };
  EXPECT_THAT(message({.title = "T", .series = {{.name = "S", .x = {0}, .y = {NAN}}}}),
              HasSubstr("plot 'T', series 'S': has values that are not finite"));
  EXPECT_THAT(message({.title = "T", .series = {{.name = "S", .x = {0, 1}, .y = {0}}}}),
              HasSubstr("x and y differ"));
}

}  // namespace
}  // namespace palpate
