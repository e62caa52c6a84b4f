#pragma once

#include <string_view>
#include <vector>

namespace palpate {

/// Of `words`, the one that a person who wrote `word` most likely meant; empty where none is near.
std::string_view NearestWord(std::string_view word, const std::vector<std::string_view>& words);

}  // namespace palpate
