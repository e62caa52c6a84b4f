#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/course/local_text.h"

namespace palpate {

/// The texts of a score page.  It is one file that speaks every language: each text stands there in
/// English with its key and values, and score_words.js says it in the reader's language.

/// The languages, English first: BCP 47 tag and catalogue (words/TAG.json).
extern const std::vector<std::pair<std::string_view, std::string_view>> kScoreCatalogues;

/// What stands in a text's braces.
struct Said {
  std::string name;
  std::vector<LocalText> values;  ///< joined in the reader's language; a plain text is English
};
using Values = std::vector<Said>;

/// Escapes any text for HTML or SVG.
std::string Escaped(const std::string& text);

/// Returns a text in English; the key itself if there is no such text.
std::string InEnglish(const std::string& key, const Values& values = {});
/// Returns a text in all languages.
LocalText InAll(const std::string& key, const Values& values = {});
/// Returns a text as an element, escaped.
std::string Say(const std::string& key, const Values& values = {});
/// The same for a text that has its own languages.  @param instead  if it has none.
std::string Say(const LocalText& text, const std::string& instead);
/// Returns the attributes of an element that is labelled by a text.
std::string Label(const std::string& key);
/// Returns the attribute that names a text for score_words.js; empty: there is no such text.
std::string KeyAttribute(const std::string& key);
/// Returns all catalogues as the script's expression.
std::string ScoreCatalogues();

}  // namespace palpate
