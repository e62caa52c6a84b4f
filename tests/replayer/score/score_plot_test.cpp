#include "client/replayer/score/score_plot.h"

#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using testing::HasSubstr;

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

ScorePlot Crowded(double greatest) {
  ScorePlot plot{.title = "Crowded", .subtitle = "many trials", .x_title = "s", .y_title = "N"};
  for (int i = 0; i < 9; ++i) {
    plot.lines.push_back({"trial with a name as long as this, number " + std::to_string(i),
                          {0.0, 0.5 * greatest},
                          {0.0, greatest}});
  }
  return plot;
}

TEST(ScorePlot, NeverWritesTextOnText) {
  for (const double greatest : {0.0, 0.0123, 8.7, 123456.0}) {
    const std::vector<Text> texts = TextsOf(ToSvg({Crowded(greatest), Crowded(greatest)}));
    ASSERT_GT(texts.size(), 28u);
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
}

TEST(ScorePlot, PlacesValuesBetweenTheTicksThatNameThem) {
  const std::string svg = ToSvg({{.lines = {{"", {0.0, 1.5, 3.0}, {0.0, 30.0, 60.0}}}}});
  std::smatch m;
  ASSERT_TRUE(std::regex_search(
      svg, m, std::regex(R"re(points="78\.0,([.0-9]+) ([.0-9]+),([.0-9]+) 934\.0,([.0-9]+) ")re")));
  const auto at = [&](std::size_t i) { return std::stod(m[i]); };
  EXPECT_NEAR(at(1) - at(4), 300.0, 0.1) << "the greatest is the last tick";
  EXPECT_NEAR(at(3), 0.5 * (at(1) + at(4)), 0.1);
  EXPECT_NEAR(at(2), 0.5 * (78.0 + 934.0), 0.1);
  EXPECT_THAT(svg, HasSubstr(">60</text>"));
}

TEST(ScorePlot, HasThePagesColoursOfBothThemes) {
  const std::string svg = ToSvg({Crowded(1.0)});
  EXPECT_THAT(svg, HasSubstr("--paper: #f4f2ee"));
  EXPECT_THAT(svg, HasSubstr("@media (prefers-color-scheme: dark) { :root {"));
  EXPECT_THAT(svg, HasSubstr("--paper: #13161b"));
  EXPECT_THAT(svg, HasSubstr("--series-8: var("));
}

}  // namespace
}  // namespace palpate
