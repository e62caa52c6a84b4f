#include "client/course/local_text.h"

#include <algorithm>
#include <cctype>

namespace palpate {

LocalText ReadLocalText(const JsonNode& node) {
  if (node.IsString()) return {{"en", node.String()}};
  LocalText text;
  for (const std::string& language : node.Fields()) {
    const JsonNode at = node.At(language);
    const bool is_code = language.size() >= 2 && language.size() <= 16 &&
                         std::ranges::all_of(language, [](unsigned char c) {
                           return c == '-' || (std::isalnum(c) != 0);
                         });
    if (!is_code) at.Fail("is not a language; give its code, such as \"en\", \"de\" or \"zh\"");
    text[language] = at.String();
  }
  if (text.empty()) node.Fail("is empty; give a text in at least one language: {\"en\": \"...\"}");
  return text;
}

std::string EnglishOf(const LocalText& text) {
  const auto english = text.find("en");
  if (english != text.end()) return english->second;
  return text.empty() ? "" : text.begin()->second;
}

}  // namespace palpate
