#include "server/transport/pose_budget.h"

#include <gtest/gtest.h>

namespace palpate::test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

/// Of poses that come `per_second` for ten seconds, how many are heard.
int Heard(std::int64_t per_second, std::int64_t begin_ns) {
  PoseBudget budget;
  int heard = 0;
  for (std::int64_t i = 0; i < 10 * per_second; ++i) {
    heard += budget.Take(begin_ns + i * kSecond_ns / per_second);
  }
  return heard;
}

TEST(PoseBudget, HearsAStationOfAThousandAndATenthMore) {
  for (const std::int64_t begin_ns : {std::int64_t{0}, 36'000 * kSecond_ns}) {
    EXPECT_EQ(Heard(1000, begin_ns), 10'000);
    EXPECT_EQ(Heard(1100, begin_ns), 11'000);
  }
}

TEST(PoseBudget, HearsOfTenTimesAsManyNoMoreThanTheShare) {
  EXPECT_NEAR(Heard(10'000, 36'000 * kSecond_ns), 10 * PoseBudget::kPerSecond + PoseBudget::kAtOnce,
              2);
}

TEST(PoseBudget, HearsWhatWaitedDuringAStall) {
  PoseBudget budget;
  ASSERT_TRUE(budget.Take(kSecond_ns));
  int heard = 0;
  for (int i = 0; i < 200; ++i) heard += budget.Take(2 * kSecond_ns);
  EXPECT_EQ(heard, PoseBudget::kAtOnce);
}

}  // namespace
}  // namespace palpate::test
