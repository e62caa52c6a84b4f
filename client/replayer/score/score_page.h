#pragma once

namespace palpate {

// score_page.css and score_page.js as text, put here by the build.
extern const char* const kScorePageCss;
extern const char* const kScorePageJs;

}  // namespace palpate
