#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// Of `words`, the one that a person who wrote `word` most likely meant; empty where none is near.
std::string_view NearestWord(std::string_view word, const std::vector<std::string_view>& words);

/// For a complaint: `; did you mean "scene"?`; empty where none is near.
std::string DidYouMean(std::string_view word, const std::vector<std::string_view>& words);
/// The same and all that there are: `; did you mean "scene"? (known: scene seed)`.
std::string DidYouMeanOneOf(std::string_view word, const std::vector<std::string_view>& words);

}  // namespace palpate
