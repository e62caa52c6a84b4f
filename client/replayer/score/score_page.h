#pragma once

namespace palpate {

// score_page.css, score_page.js, and the colours and font of the viewer's page as CSS, put here by
// the build.
extern const char* const kScorePageCss;
extern const char* const kScorePageJs;
extern const char* const kScorePagePalette;

}  // namespace palpate
