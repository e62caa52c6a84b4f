#include "client/load/frame_tally.h"

#include <optional>
#include <string>
#include <utility>

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// Two viewers of two stations that have sampled pose n at n milliseconds, and forgotten it 4 s
/// later.
class Bench {
 public:
  Bench() {
    FrameTally::Setup setup{2, 2, "load", 30.0, {}, {}};
    setup.newest_sequence = [this](std::size_t station) { return newest_[station]; };
    setup.sample_time_ns = [this](std::size_t station, std::uint64_t sequence) {
      const bool forgotten = sequence + 4000 < newest_[station];
      return forgotten ? 0 : static_cast<std::int64_t>(sequence) * kMs;
    };
    tally_.emplace(std::move(setup));
  }

  FrameTally& tally() { return *tally_; }
  /// Both stations have sent so many poses.
  void Begin(std::uint64_t newest) {
    newest_[0] = newest_[1] = newest;
    tally_->Begin(static_cast<std::int64_t>(newest) * kMs);
  }
  void End(std::uint64_t newest) {
    newest_[0] = newest_[1] = newest;
    tally_->End(static_cast<std::int64_t>(newest) * kMs);
  }
  void Get(std::size_t viewer, const std::string& station, std::uint64_t sequence,
           std::int64_t age_ms = 5) {
    wire::ToolState frame{};
    wire::FromText(station, frame.station);
    frame.pose_sequence = sequence;
    tally_->Add(viewer, frame, (static_cast<std::int64_t>(sequence) + age_ms) * kMs);
  }
  /// Each frame of the station from one pose to another, at so many a second.
  void Watch(std::size_t viewer, const std::string& station, std::uint64_t from, std::uint64_t to,
             double rate_hz = 30.0) {
    for (int i = 0;; ++i) {
      const auto sequence = from + static_cast<std::uint64_t>(i * 1e3 / rate_hz);
      if (sequence >= to) return;
      Get(viewer, station, sequence);
    }
  }

 private:
  std::uint64_t newest_[2] = {};
  std::optional<FrameTally> tally_;
};

/// 10 s at 30 Hz, less one that may be on its way.
constexpr std::uint64_t kDue = 299;

TEST(FrameTally, CountsNoLossWhereEachViewerGetsEachStationAtTheRate) {
  Bench bench;
  bench.Begin(500);
  for (const std::size_t viewer : {0, 1}) {
    for (const std::string station : {"load_1", "load_2"}) {
      bench.Watch(viewer, station, 500 + 7 * viewer, 10'495);
    }
  }
  bench.End(10'500);
  EXPECT_EQ(bench.tally().frames(), 4 * 300u);
  EXPECT_EQ(bench.tally().due(), 4 * kDue);
  EXPECT_EQ(bench.tally().lost(), 0u);
}

TEST(FrameTally, CountsAllThatIsDueToAViewerThatGetsNone) {
  Bench bench;
  bench.Begin(500);
  for (const std::string station : {"load_1", "load_2"}) {
    bench.Watch(0, station, 500, 10'495);
  }
  bench.End(10'500);
  EXPECT_EQ(bench.tally().lost(), 2 * kDue);
}

TEST(FrameTally, CountsWhatComesAfterAViewersLastFrame) {
  Bench bench;
  bench.Begin(500);
  for (const std::size_t viewer : {0, 1}) bench.Watch(viewer, "load_1", 500, 10'495);
  bench.Watch(0, "load_2", 500, 10'495);
  bench.Watch(1, "load_2", 500, 5'500);
  bench.End(10'500);
  EXPECT_EQ(bench.tally().lost(), kDue - 150);
}

TEST(FrameTally, CountsWhatAViewerAtHalfTheRateMisses) {
  Bench bench;
  bench.Begin(500);
  for (const std::size_t viewer : {0, 1}) bench.Watch(viewer, "load_1", 500, 10'495);
  // A sixth too slow: not one gap of two frames.
  bench.Watch(0, "load_2", 500, 10'495, 25.0);
  bench.Watch(1, "load_2", 500, 10'495, 15.0);
  bench.End(10'500);
  EXPECT_EQ(bench.tally().lost(), (kDue - 250) + (kDue - 150));
}

TEST(FrameTally, LetsMoreOfOneStationNotMakeGoodForLessOfAnother) {
  Bench bench;
  bench.Begin(500);
  bench.Watch(0, "load_1", 500, 10'495, 60.0);
  bench.Watch(1, "load_2", 500, 10'495, 60.0);
  bench.End(10'500);
  EXPECT_EQ(bench.tally().frames(), 2 * 600u);
  EXPECT_EQ(bench.tally().lost(), 2 * kDue);
}

TEST(FrameTally, TakesAPoseThatIsShownAgainForNoFrame) {
  Bench bench;
  bench.Begin(500);
  for (const std::size_t viewer : {0, 1}) bench.Watch(viewer, "load_1", 500, 10'495);
  bench.Watch(0, "load_2", 500, 10'495);
  for (int i = 0; i < 300; ++i) bench.Get(1, "load_2", 600);  // its server hears it no more
  bench.End(10'500);
  EXPECT_EQ(bench.tally().lost(), kDue - 1);
}

TEST(FrameTally, HoldsNothingDueOfAStationThatSendsNothing) {
  Bench bench;
  bench.Begin(0);
  bench.End(0);
  EXPECT_EQ(bench.tally().due(), 0u);
  EXPECT_EQ(bench.tally().lost(), 0u);
}

TEST(FrameTally, TakesTheAgeFromWhenTheStationSampledThePose) {
  Bench bench;
  bench.Begin(500);
  for (int i = 0; i < 99; ++i) bench.Get(0, "load_2", 1000 + 33u * static_cast<unsigned>(i), 10);
  bench.Get(0, "load_2", 1000 + 33 * 99, 40);
  EXPECT_EQ(bench.tally().age().count(), 100u);
  EXPECT_NEAR(static_cast<double>(bench.tally().age().Quantile(0.5)), 10.0 * kMs, 0.4 * kMs);
  EXPECT_EQ(bench.tally().age().max(), 40u * kMs);
}

TEST(FrameTally, CountsAFrameThatItsStationHasForgottenAsOldAsThatMakesIt) {
  Bench bench;
  bench.Begin(6000);
  bench.Get(0, "load_1", 1500, 5000);
  EXPECT_EQ(bench.tally().age().count(), 1u);
  EXPECT_EQ(bench.tally().age().max(), static_cast<std::uint64_t>(FrameTally::kForgotten_ns));
}

TEST(FrameTally, CountsWhatComesBetweenItsBeginAndItsEnd) {
  Bench bench;
  bench.Get(0, "load_1", 1);
  bench.Begin(1000);
  bench.Get(0, "load_1", 1033);
  bench.End(2000);
  bench.Get(0, "load_1", 2033);
  EXPECT_EQ(bench.tally().frames(), 1u);
  EXPECT_EQ(bench.tally().age().count(), 1u);
}

TEST(FrameTally, CountsOtherStationsFramesAndNoMoreOfThem) {
  Bench bench;
  bench.Begin(0);
  for (const std::string name :
       {"hand", "load", "load_", "load_0", "load_3", "load_1x", "loads_1", ""}) {
    bench.Get(0, name, 100);
    bench.Get(0, name, 9000);
  }
  bench.End(10'000);
  EXPECT_EQ(bench.tally().frames(), 16u);
  EXPECT_EQ(bench.tally().lost(), bench.tally().due());
  EXPECT_EQ(bench.tally().age().count(), 0u);
}

}  // namespace
}  // namespace palpate
