#include <gtest/gtest.h>

#include "client/replayer/guide/guide.h"
#include "client/station/guide.h"

namespace palpate {
namespace {

constexpr double kDt = 0.01;

static_assert(GuidePace::kNear_m == Guide::kReach_m, "what the hand is pulled by with all it may");

double TimeAfterASecond(GuidePace pace, std::optional<double> behind_m) {
  for (int i = 0; i < 100; ++i) pace.Advance(kDt, behind_m);
  return pace.time_s();
}

TEST(GuidePace, IsTheRecordedOneTimesTheRateWhileTheHandIsNear) {
  EXPECT_NEAR(TimeAfterASecond({1.0, 0.0, true}, 0.0), 1.0, 1e-12);
  EXPECT_NEAR(TimeAfterASecond({0.5, 3.0, true}, GuidePace::kNear_m), 3.5, 1e-12);
}

TEST(GuidePace, SlowsDownWithTheDistanceAndStandsBeyondIt) {
  double slower = 1.0;
  for (double behind = 0.006; behind < GuidePace::kFar_m; behind += 0.001) {
    const double time = TimeAfterASecond({1.0, 0.0, true}, behind);
    EXPECT_LT(time, slower);
    EXPECT_GT(time, 0.0);
    slower = time;
  }
  EXPECT_EQ(TimeAfterASecond({1.0, 2.0, true}, GuidePace::kFar_m), 2.0);
  EXPECT_EQ(TimeAfterASecond({1.0, 2.0, true}, 1.0), 2.0);
}

TEST(GuidePace, DoesNotWaitForAHandThatNobodyKnowsNorWhereItIsTold) {
  EXPECT_NEAR(TimeAfterASecond({1.0, 0.0, true}, std::nullopt), 1.0, 1e-12);
  EXPECT_NEAR(TimeAfterASecond({1.0, 0.0, false}, 1.0), 1.0, 1e-12);
}

TEST(GuidePace, SaysThatItWaitsOnceThoughTheHandTremblesAtItsReach) {
  GuidePace pace(1.0, 0.0, true);
  EXPECT_FALSE(pace.waiting());
  pace.Advance(kDt, 0.020);
  EXPECT_TRUE(pace.waiting());
  pace.Advance(kDt, 0.014);
  EXPECT_TRUE(pace.waiting());
  pace.Advance(kDt, 0.004);
  EXPECT_FALSE(pace.waiting());
}

/// A hand that follows at its own greatest speed arrives with the guide, and is never out of its
/// reach.
TEST(GuidePace, NeverLosesAHandThatIsSlowerThanTheExpert) {
  GuidePace pace(1.0, 0.0, true);
  double hand = 0.0;
  const double expert_m_s = 0.1, hand_m_s = 0.03;
  int ticks = 0;
  for (; pace.time_s() < 2.0; ++ticks) {
    const double behind = expert_m_s * pace.time_s() - hand;
    ASSERT_LE(behind, GuidePace::kFar_m + expert_m_s * kDt);
    pace.Advance(kDt, behind);
    hand += hand_m_s * kDt;
  }
  EXPECT_NEAR(ticks * kDt, 2.0 * expert_m_s / hand_m_s, 0.7);
}

}  // namespace
}  // namespace palpate
