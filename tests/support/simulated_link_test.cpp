#include "tests/support/simulated_link.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace palpate::test {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;

struct Arrived {
  std::int64_t time_ns;
  int sample;
  bool operator==(const Arrived&) const = default;
};

/// Sends 0, 1, 2 ... one per millisecond, and polls for arrivals a hundred times per millisecond.
std::vector<Arrived> Travel(LossyWay<int> way, int samples) {
  constexpr std::int64_t kLook = kMillisecond / 100;
  std::vector<Arrived> arrived;
  for (std::int64_t now = 0; now < (samples + 1000) * kMillisecond; now += kLook) {
    if (now % kMillisecond == 0 && now < samples * kMillisecond) {
      way.Send(now, static_cast<int>(now / kMillisecond));
    }
    while (const auto sample = way.Receive(now)) arrived.push_back({now, *sample});
  }
  return arrived;
}

std::vector<Arrived> Travel(const LinkConditions& conditions, int samples, std::uint64_t seed = 1) {
  return Travel(LossyWay<int>(seed, conditions), samples);
}

int OutOfOrder(const std::vector<Arrived>& arrived) {
  int count = 0, newest = -1;
  for (const Arrived& each : arrived) {
    count += each.sample < newest;
    newest = std::max(newest, each.sample);
  }
  return count;
}

TEST(SimulatedLink, OfNoFaultsHandsOverAtOnceOnceAndInOrder) {
  const std::vector<Arrived> arrived = Travel({}, 50);
  ASSERT_EQ(arrived.size(), 50u);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(arrived[i], (Arrived{i * kMillisecond, i}));
}

TEST(SimulatedLink, JitterStaysWithinItsBoundsAndKeepsTheOrder) {
  const std::vector<Arrived> arrived =
      Travel({.delay_ns = 2 * kMillisecond, .jitter_ns = 4 * kMillisecond}, 2000);
  ASSERT_EQ(arrived.size(), 2000u);
  EXPECT_EQ(OutOfOrder(arrived), 0);
  std::int64_t least = 1000 * kMillisecond, most = 0;
  for (const Arrived& each : arrived) {
    least = std::min(least, each.time_ns - each.sample * kMillisecond);
    most = std::max(most, each.time_ns - each.sample * kMillisecond);
  }
  EXPECT_GE(least, 2 * kMillisecond);
  EXPECT_LT(least, 3 * kMillisecond);
  EXPECT_GT(most, 5 * kMillisecond);
  EXPECT_LE(most, 6 * kMillisecond + kMillisecond / 100);  // noticed by the next poll
}

TEST(SimulatedLink, LosesTheShareThatItIsToldTo) {
  EXPECT_TRUE(Travel({.loss = 1.0}, 100).empty());
  // The standard deviation of 10,000 throws is 0.0046.
  EXPECT_NEAR(static_cast<double>(Travel({.loss = 0.3}, 10'000).size()) / 10'000, 0.7, 0.02);
}

TEST(SimulatedLink, DoublesTheShareThatItIsToldTo) {
  const std::vector<Arrived> arrived = Travel({.duplication = 0.25}, 10'000);
  EXPECT_NEAR(static_cast<double>(arrived.size()) / 10'000, 1.25, 0.02);
  std::vector<int> times(10'000);
  for (const Arrived& each : arrived) ++times[each.sample];
  EXPECT_EQ(*std::min_element(times.begin(), times.end()), 1);
  EXPECT_EQ(*std::max_element(times.begin(), times.end()), 2);
}

TEST(SimulatedLink, ReordersOnlyByHoldingSamplesBack) {
  const std::vector<Arrived> arrived = Travel({.reordering = 0.1}, 10'000);
  ASSERT_EQ(arrived.size(), 10'000u);
  // Held back by 0 to 5 ms: four fifths of them long enough to be overtaken.
  EXPECT_NEAR(static_cast<double>(OutOfOrder(arrived)) / 10'000, 0.08, 0.02);
}

}  // namespace
}  // namespace palpate::test
