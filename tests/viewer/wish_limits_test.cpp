#include "client/viewer/wish_limits.h"

#include <gtest/gtest.h>

#include "client/viewer/viewer_limits.h"

namespace palpate {
namespace {

constexpr std::int64_t kMinute_ns = 60'000'000'000;
constexpr std::int64_t kStep_ns = 10'000'000;
constexpr ViewerLimits::Rate kOwn = ViewerLimits::kTake.of_viewer;
constexpr ViewerLimits::Rate kAll = ViewerLimits::kTake.of_address;

TEST(WishLimits, LetAHandTakeSeveralToolsInTurn) {
  WishLimits limits;
  for (int i = 0; i < kOwn.at_once; ++i) EXPECT_TRUE(limits.Ask(Wish::kTake, 1, "a", 0).granted);
  EXPECT_FALSE(limits.Ask(Wish::kTake, 1, "a", 0).granted);
  EXPECT_TRUE(limits.Ask(Wish::kTake, 1, "a", kOwn.period_ns).granted);
}

TEST(WishLimits, HoldAViewerThatTakesOnAndOnToAFewAMinuteAndTellItOnce) {
  WishLimits limits;
  int taken = 0, told = 0;
  for (std::int64_t now = 0; now < kMinute_ns; now += kStep_ns) {
    const WishLimits::Verdict verdict = limits.Ask(Wish::kTake, 1, "a", now);
    taken += verdict.granted;
    told += verdict.tell;
    EXPECT_FALSE(verdict.granted && verdict.tell);
  }
  EXPECT_EQ(taken, kOwn.at_once + kMinute_ns / kOwn.period_ns - 1);
  EXPECT_EQ(told, 1);
  // After a rest it is told again.
  std::int64_t now = 2 * kMinute_ns;
  while (limits.Ask(Wish::kTake, 1, "a", now).granted) {
  }
  EXPECT_FALSE(limits.Ask(Wish::kTake, 1, "a", now).tell) << "told where the loop above ended";
  now += kMinute_ns;
  for (int i = 0; i < kOwn.at_once; ++i) EXPECT_TRUE(limits.Ask(Wish::kTake, 1, "a", now).granted);
  EXPECT_TRUE(limits.Ask(Wish::kTake, 1, "a", now).tell);
}

TEST(WishLimits, HoldAnAddressThatComesBackAsAnotherViewerEachTime) {
  WishLimits limits;
  int taken = 0;
  std::uint64_t viewer = 0;
  for (std::int64_t now = 0; now < kMinute_ns; now += kStep_ns) {
    taken += limits.Ask(Wish::kTake, ++viewer, "a", now).granted;
    limits.Leave(viewer);
  }
  EXPECT_LE(taken, kAll.at_once + kMinute_ns / kAll.period_ns);
  EXPECT_TRUE(limits.Ask(Wish::kTake, ++viewer, "b", kMinute_ns).granted)
      << "another address is not concerned";
}

TEST(WishLimits, OfOneKindTakeNothingFromAnother) {
  WishLimits limits;
  while (limits.Ask(Wish::kReplay, 1, "a", 0).granted) {
  }
  for (const Wish wish : {Wish::kTake, Wish::kWhole, Wish::kOperate, Wish::kSubscribe}) {
    EXPECT_TRUE(limits.Ask(wish, 1, "a", 0).granted);
  }
}

TEST(WishLimits, AllowWhatThePageAndATeacherDo) {
  WishLimits limits;
  for (int i = 0; i < 60; ++i) EXPECT_TRUE(limits.Ask(Wish::kOperate, 1, "a", 0).granted) << i;
  // Dragging a bar for a minute makes five wishes a second.
  for (std::int64_t now = 0; now < kMinute_ns; now += 200'000'000) {
    EXPECT_TRUE(limits.Ask(Wish::kReplay, 1, "a", now).granted);
  }
  // A class behind one router reconnects at once.
  for (std::uint64_t viewer = 1; viewer <= 300; ++viewer) {
    for (int channel = 0; channel < 11; ++channel) {
      ASSERT_TRUE(limits.Ask(Wish::kSubscribe, viewer, "a", kMinute_ns).granted) << viewer;
    }
  }
}

TEST(WishLimits, RememberNoAddressThatHasRested) {
  WishLimits limits;
  for (int i = 0; i < 1000; ++i) {
    limits.Ask(Wish::kTake, 1 + i, "address " + std::to_string(i), i * kMinute_ns);
    limits.Leave(1 + i);
    EXPECT_LE(limits.addresses(), 1u);
  }
}

}  // namespace
}  // namespace palpate
