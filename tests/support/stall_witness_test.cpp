#include "tests/support/stall_witness.h"

#include <gtest/gtest-spi.h>

namespace palpate::test {
namespace {

TEST(Shown, MakesNoFurtherAttemptOnceOneHasShownOrFailed) {
  int attempts = 0;
  EXPECT_TRUE(Shown([&](StallWitness&) { return ++attempts, Attempt::kShown; }));
  EXPECT_FALSE(Shown([&](StallWitness&) { return ++attempts, Attempt::kFailed; }));
  EXPECT_EQ(attempts, 2);
}

TEST(Shown, TakesNothingThatIsSpoiltForAStallWhereTheWitnessSawNone) {
  int attempts = 0;
  // No machine stalls for a day while this runs.
  EXPECT_FALSE(Shown([&](StallWitness&) { return ++attempts, Attempt::kSpoilt; }, 86.4e6));
  EXPECT_EQ(attempts, 1);
}

TEST(Shown, TriesAgainAfterAStallButNotForEver) {
  int attempts = 0;
  const auto spoilt_once = [&](StallWitness&) {
    return ++attempts == 1 ? Attempt::kSpoilt : Attempt::kShown;
  };
  EXPECT_TRUE(Shown(spoilt_once, 0.0));
  EXPECT_EQ(attempts, 2);
  attempts = 0;
  testing::TestPartResultArray results;
  {
    const testing::ScopedFakeTestPartResultReporter reporter(
        testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &results);
    EXPECT_TRUE(Shown([&](StallWitness&) { return ++attempts, Attempt::kSpoilt; }, 0.0));
  }
  EXPECT_EQ(attempts, 5);
  ASSERT_EQ(results.size(), 1);
  EXPECT_TRUE(results.GetTestPartResult(0).skipped());
}

}  // namespace
}  // namespace palpate::test
