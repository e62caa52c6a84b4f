#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/error.h"

namespace palpate::test {

/// A program's own parser of its command line.
template <class Options>
using OptionsParser = std::optional<Options> (*)(int argc, const char* const* argv);

/// Returns the options that it parses from the words after the program's name.
template <class Options>
std::optional<Options> ParseWith(OptionsParser<Options> parse, std::vector<const char*> words) {
  words.insert(words.begin(), "/somewhere/bin/palpate");
  return parse(static_cast<int>(words.size()), words.data());
}

/// Returns its complaint about the words; nothing if it accepts them.
template <class Options>
std::string ComplaintOf(OptionsParser<Options> parse, const std::vector<const char*>& words) {
  try {
    ParseWith(parse, words);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

}  // namespace palpate::test
