#pragma once

#include <cstdlib>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/read_file.h"

namespace palpate::test {

/// Expects that a text is, to the letter, the one in a file of the source tree, which people have
/// read and approved.  With PALPATE_APPROVE=1 in the environment it is written there instead, so
/// that `git diff` shows what has changed.
inline void ExpectApproved(const std::string& file, const std::string& text) {
  const std::string path = PALPATE_SOURCE_DIR "/" + file;
  if (std::getenv("PALPATE_APPROVE") != nullptr) std::ofstream(path, std::ios::binary) << text;
  EXPECT_EQ(text, ReadWholeFile(path)) << "run with PALPATE_APPROVE=1 and read what git diff shows";
}

}  // namespace palpate::test
