#include "tests/support/stall_witness.h"

#include <chrono>
#include <vector>

#include <gtest/gtest-spi.h>
#include <sched.h>
#include <unistd.h>

#include "tests/support/program.h"

namespace palpate::test {
namespace {

/// Keeps this process and its children on one processor while it lives, so that they compete.
class OneProcessor {
 public:
  OneProcessor() {
    sched_getaffinity(0, sizeof before_, &before_);
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(sched_getcpu(), &one);
    sched_setaffinity(0, sizeof one, &one);
  }
  ~OneProcessor() { sched_setaffinity(0, sizeof before_, &before_); }

 private:
  cpu_set_t before_;
};

TEST(StallWitness, AddsUpWhatIsLostBitByBit) {
  StallWitness witness;
  const OneProcessor one;
  // Two busy processes alternate every few milliseconds: of 100 ms each waits for about half.
  std::vector<std::unique_ptr<Program>> busy;
  for (int i = 0; i < 2; ++i) {
    busy.push_back(std::make_unique<Program>(
        "/bin/sh", std::vector<std::string>{"-c", "while :; do :; done"}));
    witness.Watch(busy.back()->id());
  }
  for (int i = 0; i < 2000 && witness.longest_ms() < 33.0; ++i) usleep(10'000);
  EXPECT_GE(witness.longest_ms(), 33.0);
}

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
