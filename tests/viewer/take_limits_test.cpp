#include "client/viewer/take_limits.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr std::int64_t kMinute_ns = 60'000'000'000;
constexpr std::int64_t kStep_ns = 10'000'000;

TEST(TakeLimits, LetAHandTakeSeveralToolsInTurn) {
  TakeLimits limits;
  for (int i = 0; i < TakeLimits::kAtOnce; ++i) EXPECT_TRUE(limits.Pass(1, "a", 0));
  EXPECT_FALSE(limits.Pass(1, "a", 0));
  EXPECT_TRUE(limits.Pass(1, "a", TakeLimits::kPeriod_ns));
}

TEST(TakeLimits, HoldAViewerThatTakesOnAndOnToAFewAMinute) {
  TakeLimits limits;
  int taken = 0;
  for (std::int64_t now = 0; now < kMinute_ns; now += kStep_ns) taken += limits.Pass(1, "a", now);
  EXPECT_EQ(taken, TakeLimits::kAtOnce + kMinute_ns / TakeLimits::kPeriod_ns - 1);
}

TEST(TakeLimits, HoldAnAddressThatComesBackAsAnotherViewerEachTime) {
  TakeLimits limits;
  int taken = 0;
  std::uint64_t viewer = 0;
  for (std::int64_t now = 0; now < kMinute_ns; now += kStep_ns) {
    taken += limits.Pass(++viewer, "a", now);
    limits.Leave(viewer);
  }
  EXPECT_LE(taken, TakeLimits::kAtOnceOfAnAddress + kMinute_ns / TakeLimits::kPeriodOfAnAddress_ns);
  EXPECT_TRUE(limits.Pass(++viewer, "b", kMinute_ns)) << "another address is not concerned";
}

}  // namespace
}  // namespace palpate
