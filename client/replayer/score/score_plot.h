#pragma once

#include <string>
#include <vector>

namespace palpate {

/// A plot of lines over time, with both axes from 0.
struct ScorePlot {
  struct Line {
    std::string name;  ///< in the legend
    std::vector<double> x, y;
  };
  std::string title = {}, subtitle = {};   ///< texts, or keys of score_words.h
  std::string x_title = {}, y_title = {};  ///< likewise; with units
  std::vector<Line> lines = {};  ///< colours go by position in this list, the same in every plot
};

/// Returns the plots, one below the other, in the colours of the web page, light or dark as the
/// reader prefers.  Labels never overlap.
std::string ToSvg(const std::vector<ScorePlot>& plots);

// score_page.css, score_page.js, score_cut.js, score_words.js, and colours and font of the viewer's
// page as CSS, embedded by the build.
extern const char* const kScorePageCss;
extern const char* const kScorePageJs;
extern const char* const kScoreCutJs;
extern const char* const kScoreWordsJs;
extern const char* const kScorePagePalette;

}  // namespace palpate
