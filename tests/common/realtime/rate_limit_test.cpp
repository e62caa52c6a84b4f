#include "common/realtime/rate_limit.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr std::int64_t kS = RateLimit::kSecond_ns;

TEST(RateLimit, LetsOnePassInAPeriodWhateverComes) {
  RateLimit limit;
  int passed = 0;
  for (std::int64_t now = 5 * kS; now < 15 * kS; now += kS / 1000)
    passed += limit.Pass(now) ? 1 : 0;
  EXPECT_EQ(passed, 10);
  EXPECT_EQ(limit.TakeHeldBack(), 9990u);
  EXPECT_EQ(limit.TakeHeldBack(), 0u);
}

TEST(RateLimit, LetsSomePassTogetherAfterARestAndNoMoreThanThem) {
  RateLimit limit(2 * kS, 3);
  const auto burst = [&](std::int64_t now) {
    int passed = 0;
    for (int i = 0; i < 10; ++i) passed += limit.Pass(now) ? 1 : 0;
    return passed;
  };
  EXPECT_EQ(burst(0), 3);
  EXPECT_EQ(burst(2 * kS), 1);
  EXPECT_EQ(burst(3 * kS), 0);
  EXPECT_EQ(burst(100 * kS), 3) << "a long rest saves up no more than that";
}

TEST(RateLimit, OwesAWordOnThoseHeldBackOnceThereIsRoom) {
  RateLimit limit;
  limit.Pass(0);
  EXPECT_FALSE(limit.OwesWord(2 * kS)) << "none was held back";
  limit.Pass(2 * kS);
  limit.Pass(2 * kS + 1);
  EXPECT_FALSE(limit.OwesWord(2 * kS + 2));
  EXPECT_TRUE(limit.OwesWord(3 * kS));
  EXPECT_EQ(limit.TakeHeldBack(), 1u);
  EXPECT_FALSE(limit.OwesWord(3 * kS));
}

TEST(RateLimit, IsRestedOnceItWouldTreatAllAsNew) {
  RateLimit limit(kS, 2);
  EXPECT_TRUE(limit.IsRested(0));
  limit.Pass(0);
  EXPECT_FALSE(limit.IsRested(kS - 1));
  EXPECT_TRUE(limit.IsRested(kS));
}

}  // namespace
}  // namespace palpate
