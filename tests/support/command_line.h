#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/error.h"

namespace palpate::test {

/// A program's own reading of its command line.
template <class Options>
using OptionsParser = std::optional<Options> (*)(int argc, const char* const* argv);

/// What it makes of the words behind the program's name.
template <class Options>
std::optional<Options> ParseWith(OptionsParser<Options> parse, std::vector<const char*> words) {
  words.insert(words.begin(), "/somewhere/bin/palpate");
  return parse(static_cast<int>(words.size()), words.data());
}

/// What it says against them; nothing where it takes them.
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
