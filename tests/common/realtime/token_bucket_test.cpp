#include "common/realtime/token_bucket.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace palpate::test {
namespace {

constexpr std::int64_t kMillisecond_ns = 1'000'000;
constexpr std::int64_t kSecond_ns = 1000 * kMillisecond_ns;

TEST(TokenBucket, GivesSoManyAtOnceAndThenItsRate) {
  TokenBucket bucket(10.0, 5.0);
  int taken = 0;
  for (int i = 0; i < 100; ++i) taken += bucket.Take(kSecond_ns);
  EXPECT_EQ(taken, 5);
  EXPECT_EQ(bucket.WaitFor(1.0, kSecond_ns), kSecond_ns / 10);
  for (int ms = 0; ms < 10'000; ++ms) taken += bucket.Take(kSecond_ns + kMillisecond_ns * ms);
  EXPECT_NEAR(taken, 105, 1);
}

TEST(TokenBucket, GivesInNoStretchOfTimeMoreThanItsRateAndWhatIsThereAtOnce) {
  Random random(7);
  TokenBucket bucket(100.0, 8.0);
  std::vector<std::int64_t> taken;
  for (std::int64_t now_ns = 0; now_ns < 20 * kSecond_ns;) {
    now_ns += static_cast<std::int64_t>(random.Uniform(0.0, 2e7));
    if (bucket.Take(now_ns)) taken.push_back(now_ns);
  }
  ASSERT_GT(taken.size(), 1000u);
  for (std::size_t i = 0; i < taken.size(); ++i) {
    for (std::size_t j = i; j < std::min(taken.size(), i + 200); ++j) {
      const double seconds = 1e-9 * static_cast<double>(taken[j] - taken[i]);
      ASSERT_LE(static_cast<double>(j - i), 100.0 * seconds + 8.0);
    }
  }
}

TEST(TokenBucket, IsPaidForByWaiting) {
  TokenBucket bucket(1.0, 2.0);
  bucket.Spend(5.0, 0);
  EXPECT_EQ(bucket.WaitFor(0.0, 0), 3 * kSecond_ns);
  EXPECT_FALSE(bucket.Take(3 * kSecond_ns));
  EXPECT_TRUE(bucket.Take(4 * kSecond_ns));
}

}  // namespace
}  // namespace palpate::test
