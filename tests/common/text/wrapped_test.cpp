#include "common/text/wrapped.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using testing::ElementsAre;

TEST(Wrapped, BreaksAtSpacesAndFillsEachLine) {
  EXPECT_THAT(Wrapped("one two three", 7), ElementsAre("one two", "three"));
  EXPECT_THAT(Wrapped("one two three", 13), ElementsAre("one two three"));
}

TEST(Wrapped, KeepsALongWordWhole) {
  EXPECT_THAT(Wrapped("see /a/long/path now", 5), ElementsAre("see", "/a/long/path", "now"));
}

TEST(Wrapped, KeepsTwoSpacesBetweenSentences) {
  EXPECT_THAT(Wrapped("One.  Two.", 20), ElementsAre("One.  Two."));
}

TEST(Wrapped, IsOneEmptyLineOfNothing) {
  EXPECT_THAT(Wrapped("", 5), ElementsAre(""));
}

}  // namespace
}  // namespace palpate
