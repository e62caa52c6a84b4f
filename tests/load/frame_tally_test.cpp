#include "client/load/frame_tally.h"

#include <string>

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// Two viewers of two stations that have sampled pose n at n milliseconds.
struct Bench {
  FrameTally tally{{2, 2, "load", 30.0, [](std::size_t, std::uint64_t sequence) {
                      return static_cast<std::int64_t>(sequence) * kMs;
                    }}};

  void Get(std::size_t viewer, const std::string& station, std::uint64_t sequence,
           std::int64_t age_ms = 5) {
    wire::ToolState frame{};
    wire::FromText(station, frame.station);
    frame.pose_sequence = sequence;
    tally.Add(viewer, frame, (static_cast<std::int64_t>(sequence) + age_ms) * kMs);
  }
};

TEST(FrameTally, CountsNoLossInWhatTheRateLeavesOut) {
  Bench bench;
  bench.tally.Begin(0);
  // Two or three of the server's frames apart, as 60 Hz are brought down to 30.
  std::uint64_t sequence = 1;
  for (const std::uint64_t step : {33, 34, 50, 33, 66, 34}) {
    bench.Get(0, "load_1", sequence += step);
  }
  EXPECT_EQ(bench.tally.frames(), 6u);
  EXPECT_EQ(bench.tally.lost(), 0u);
}

TEST(FrameTally, CountsTheFramesThatAGapHasRoomFor) {
  Bench bench;
  bench.tally.Begin(0);
  bench.Get(0, "load_1", 100);
  bench.Get(0, "load_1", 167);
  EXPECT_EQ(bench.tally.lost(), 1u);
  bench.Get(0, "load_1", 1167);
  EXPECT_EQ(bench.tally.lost(), 1u + 29u);
}

TEST(FrameTally, KeepsViewersAndStationsApart) {
  Bench bench;
  bench.tally.Begin(0);
  bench.Get(0, "load_1", 1000);
  bench.Get(0, "load_2", 5000);
  bench.Get(1, "load_1", 9000);
  bench.Get(0, "load_1", 1033);
  bench.Get(0, "load_2", 5033);
  bench.Get(1, "load_1", 9033);
  EXPECT_EQ(bench.tally.lost(), 0u);
}

TEST(FrameTally, TakesTheAgeFromWhenTheStationSampledThePose) {
  Bench bench;
  bench.tally.Begin(0);
  for (int i = 0; i < 99; ++i) bench.Get(0, "load_2", 1000 + 33u * static_cast<unsigned>(i), 10);
  bench.Get(0, "load_2", 1000 + 33 * 99, 40);
  EXPECT_EQ(bench.tally.age().count(), 100u);
  EXPECT_NEAR(static_cast<double>(bench.tally.age().Quantile(0.5)), 10.0 * kMs, 0.4 * kMs);
  EXPECT_EQ(bench.tally.age().max(), 40u * kMs);
}

TEST(FrameTally, ForgetsWhatCameBeforeItBegan) {
  Bench bench;
  bench.Get(0, "load_1", 1);
  bench.Get(0, "load_1", 1000);  // a gap
  bench.tally.Begin(1010 * kMs);
  bench.Get(0, "load_1", 1033);
  EXPECT_EQ(bench.tally.frames(), 1u);
  EXPECT_EQ(bench.tally.lost(), 0u);
  EXPECT_EQ(bench.tally.age().count(), 1u);
}

TEST(FrameTally, CountsOtherStationsFramesAndNoMoreOfThem) {
  Bench bench;
  bench.tally.Begin(0);
  for (const std::string name :
       {"hand", "load", "load_", "load_0", "load_3", "load_1x", "loads_1", ""}) {
    bench.Get(0, name, 100);
    bench.Get(0, name, 9000);
  }
  EXPECT_EQ(bench.tally.frames(), 16u);
  EXPECT_EQ(bench.tally.lost(), 0u);
  EXPECT_EQ(bench.tally.age().count(), 0u);
}

}  // namespace
}  // namespace palpate
