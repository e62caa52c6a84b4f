#include "client/viewer/quoted.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(Quoted, IsShortAndOfOneLine) {
  EXPECT_EQ(Quoted("cube"), "'cube'");
  EXPECT_EQ(Quoted("a\nready: \x1b[31m"), "'a?ready: ?[31m'");
  EXPECT_EQ(Quoted(std::string(40, 'x')), "'" + std::string(40, 'x') + "'");
  EXPECT_EQ(Quoted(std::string(60'000, 'x')), "'" + std::string(40, 'x') + "…'");
}

}  // namespace
}  // namespace palpate
