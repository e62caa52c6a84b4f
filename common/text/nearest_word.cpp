#include "common/text/nearest_word.h"

#include <algorithm>

namespace palpate {

std::string_view NearestWord(std::string_view word, const std::vector<std::string_view>& words) {
  // Levenshtein distance; up to a third of the word may be wrong.
  std::string_view best;
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (std::string_view candidate : words) {
    std::vector<std::size_t> row(candidate.size() + 1);
    for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= word.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i;
      for (std::size_t j = 1; j < row.size(); ++j) {
        const std::size_t change = diagonal + (word[i - 1] != candidate[j - 1]);
        diagonal = row[j];
        row[j] = std::min({change, row[j] + 1, row[j - 1] + 1});
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  return best;
}

std::string DidYouMean(std::string_view word, const std::vector<std::string_view>& words) {
  const std::string guess(NearestWord(word, words));
  return guess.empty() ? "" : "; did you mean \"" + guess + "\"?";
}

std::string DidYouMeanOneOf(std::string_view word, const std::vector<std::string_view>& words) {
  std::string text = DidYouMean(word, words) + " (known:";
  for (const std::string_view known : words) text.append(" ").append(known);
  return text + ")";
}

}  // namespace palpate
