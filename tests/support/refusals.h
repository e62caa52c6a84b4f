#pragma once

#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace palpate::test {

/// Expects of each case in a file what is to be said of it.  A case is a line that must be part of
/// that, and then a line for each input, which begins with '|', and in which \n ends a line.  Cases
/// have an empty line between them.
/// @param file  from the root of the source tree.   @param say  is given a case's inputs.
inline void ExpectRefusals(
    const std::string& file,
    const std::function<std::string(const std::vector<std::string>& inputs)>& say) {
  std::ifstream in(PALPATE_SOURCE_DIR "/" + file);
  EXPECT_NE(in.peek(), std::ifstream::traits_type::eof()) << file << " has no case";
  for (std::string part; std::getline(in, part);) {
    std::vector<std::string> inputs;
    for (std::string line; std::getline(in, line) && !line.empty();) {
      std::string& input = inputs.emplace_back(line.substr(1));
      for (std::size_t at; (at = input.find("\\n")) != input.npos;) input.replace(at, 2, "\n");
    }
    EXPECT_THAT(say(inputs), testing::HasSubstr(part)) << file;
  }
}

}  // namespace palpate::test
