#include "client/station/statistics_period.h"

#include <vector>

#include <gtest/gtest.h>

namespace palpate {
namespace {

StationSnapshot Quarter(int i) {
  StationSnapshot s;
  s.time_ns = 250'000'000ll * (i + 1);
  s.ticks = 250;
  s.replies = 200;
  s.sent = 250u * static_cast<unsigned>(i + 1);
  s.late = static_cast<unsigned>(i);
  s.limiter.calls = 250u * static_cast<unsigned>(i + 1);
  s.limiter.braked = 3u * static_cast<unsigned>(i + 1);
  s.silence_s_max = i == 2 ? 0.012 : 0.001;
  s.peak_force_N = i == 6 ? 4.0 : 1.0;
  s.status = 1u << i;
  s.energy_J = 0.1 * i;
  return s;
}

TEST(StatisticsPeriod, SumsTheSnapshotsOfASecond) {
  StatisticsPeriod period("hand", "an arm");
  std::vector<wire::StationStatistics> given;
  for (int i = 0; i < 9; ++i) {
    if (const auto figures = period.Add(Quarter(i), i >= 5 ? 7 : 0, 42)) given.push_back(*figures);
  }
  ASSERT_EQ(given.size(), 2u);
  const wire::StationStatistics& second = given[1];
  EXPECT_STREQ(second.station, "hand");
  EXPECT_STREQ(second.device, "an arm");
  EXPECT_EQ(second.run, 42u);
  EXPECT_DOUBLE_EQ(second.period_s, 1.0);
  EXPECT_EQ(second.ticks, 1000u);
  EXPECT_EQ(second.replies, 800u);
  EXPECT_EQ(second.sent, 1000u);
  EXPECT_EQ(second.late, 4u);
  EXPECT_EQ(second.missed_ticks, 7u);
  EXPECT_EQ(second.braked, 12u);
  EXPECT_EQ(second.silence_s_max, 0.001);
  EXPECT_EQ(given[0].silence_s_max, 0.012);
  EXPECT_EQ(second.applied_force_N_max, 4.0);
  EXPECT_EQ(second.device_status, (1u << 5) | (1u << 6) | (1u << 7) | (1u << 8));
  EXPECT_DOUBLE_EQ(second.energy_J, 0.8);
}

TEST(StatisticsPeriod, EndsWithARunSoThatItsSumsAreTheRuns) {
  StatisticsPeriod period("hand", "an arm");
  std::uint64_t ticks = 0, braked = 0;
  for (int i = 0; i < 7; ++i) {
    const auto figures = period.Add(Quarter(i), 0, 1, i == 6);
    if (!figures) continue;
    ticks += figures->ticks;
    braked += figures->braked;
  }
  EXPECT_EQ(ticks, Quarter(6).limiter.calls);
  EXPECT_EQ(braked, Quarter(6).limiter.braked);
}

TEST(StatisticsPeriod, CountsFromZeroWhereTotalsWereRestarted) {
  StatisticsPeriod period("hand", "an arm");
  for (int i = 0; i < 5; ++i) period.Add(Quarter(i), 0, 1);
  StationSnapshot restarted = Quarter(12);
  restarted.sent = 30;
  restarted.limiter.braked = 50;
  const auto figures = period.Add(restarted, 0, 1);
  ASSERT_TRUE(figures);
  EXPECT_EQ(figures->sent, 30u);
  EXPECT_EQ(figures->braked, 35u);
}

}  // namespace
}  // namespace palpate
