#pragma once

#include <string>
#include <vector>

namespace palpate {

/// Lines over time, from 0 on both axes.
struct ScorePlot {
  struct Line {
    std::string name;  ///< in the legend
    std::vector<double> x, y;
  };
  std::string title = {}, subtitle = {};
  std::string x_title = {}, y_title = {};  ///< with units
  std::vector<Line> lines = {};  ///< one of the same place has the same colour in every plot
};

/// The plots one below the other, in the colours of the web page, light or dark as the reader
/// prefers.  Text never lies on text.
std::string ToSvg(const std::vector<ScorePlot>& plots);

// score_page.css, score_page.js, score_cut.js, and the colours and font of the viewer's page as
// CSS, put here by the build.
extern const char* const kScorePageCss;
extern const char* const kScorePageJs;
extern const char* const kScoreCutJs;
extern const char* const kScorePagePalette;

/// Text as HTML or SVG, whatever it is.
std::string Escaped(const std::string& text);

}  // namespace palpate
