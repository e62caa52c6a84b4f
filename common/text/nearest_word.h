#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// Returns the one of `words` that a person who wrote `word` most likely meant; empty if none
/// is close.
std::string_view NearestWord(std::string_view word, const std::vector<std::string_view>& words);

/// Returns the end of a complaint: `; did you mean "scene"?`; empty if none is close.
std::string DidYouMean(std::string_view word, const std::vector<std::string_view>& words);
/// The same, followed by all known words: `; did you mean "scene"? (known: scene seed)`.
std::string DidYouMeanOneOf(std::string_view word, const std::vector<std::string_view>& words);

}  // namespace palpate
