#include "client/load/frame_tally.h"

#include <gtest/gtest.h>

#include "tests/support/milliseconds.h"

namespace palpate {
namespace {

/// Two viewers and two stations, which sample pose n at n milliseconds and remember it for 4 s.
class TallyOfFrames : public testing::Test {
 protected:
  /// Begins when both stations have sent `newest` poses.
  void Begin(std::uint64_t newest) {
    newest_ = newest;
    tally_.Begin(static_cast<std::int64_t>(newest) * kMs);
  }
  void End(std::uint64_t newest) {
    newest_ = newest;
    tally_.End(static_cast<std::int64_t>(newest) * kMs);
  }
  void Get(std::size_t viewer, const std::string& station, std::uint64_t sequence,
           std::int64_t age_ms = 5) {
    wire::ToolState frame{};
    wire::FromText(station, frame.station);
    frame.pose_sequence = sequence;
    tally_.Add(viewer, frame, (static_cast<std::int64_t>(sequence) + age_ms) * kMs);
  }
  /// Gives the viewer every frame of the station in [from, to), at `rate_hz`.
  void Watch(std::size_t viewer, const std::string& station, std::uint64_t from, std::uint64_t to,
             double rate_hz = 30.0) {
    for (int i = 0;; ++i) {
      const auto sequence = from + static_cast<std::uint64_t>(i * 1e3 / rate_hz);
      if (sequence >= to) return;
      Get(viewer, station, sequence);
    }
  }

  std::uint64_t newest_ = 0;
  FrameTally tally_{{2, 2, "load", 30.0, [this](std::size_t) { return newest_; },
                     [this](std::size_t, std::uint64_t sequence) {
                       return sequence + 4000 < newest_ ? 0
                                                        : static_cast<std::int64_t>(sequence) * kMs;
                     }}};
};

/// 10 s at 30 Hz, less one frame that may be on its way.
constexpr std::uint64_t kDue = 299;

TEST_F(TallyOfFrames, CountsNoLossWhereEachViewerGetsEachStationAtTheRate) {
  Begin(500);
  for (const std::size_t viewer : {0, 1}) {
    for (const char* station : {"load_1", "load_2"}) {
      Watch(viewer, station, 500 + 7 * viewer, 10'495);
    }
  }
  End(10'500);
  EXPECT_EQ(tally_.frames(), 4 * 300u);
  EXPECT_EQ(tally_.due(), 4 * kDue);
  EXPECT_EQ(tally_.lost(), 0u);
}

/// What two viewers, who see all of load_1, see of load_2: each from pose 500 up to `until`, at
/// `rate_hz`; `lost` is how much of it they lose.
struct Seen {
  const char* what;
  std::uint64_t until[2];
  double rate_hz[2];
  std::uint64_t lost;
};

class LossOfFrames : public TallyOfFrames, public testing::WithParamInterface<Seen> {};

TEST_P(LossOfFrames, IsCountedOfEachViewerAndStation) {
  Begin(500);
  for (const std::size_t viewer : {0, 1}) {
    Watch(viewer, "load_1", 500, 10'495);
    Watch(viewer, "load_2", 500, GetParam().until[viewer], GetParam().rate_hz[viewer]);
  }
  End(10'500);
  EXPECT_EQ(tally_.lost(), GetParam().lost);
}

INSTANTIATE_TEST_SUITE_P(
    Each, LossOfFrames,
    testing::Values(
        Seen{"AllOfIt", {10'495, 500}, {30.0, 30.0}, kDue},
        Seen{"AfterTheLastFrame", {10'495, 5'500}, {30.0, 30.0}, kDue - 150},
        // A sixth too slow, though no gap is two frames long.
        Seen{"AtLessThanTheRate", {10'495, 10'495}, {25.0, 15.0}, (kDue - 250) + (kDue - 150)}),
    [](const auto& seen) { return seen.param.what; });

TEST_F(TallyOfFrames, LetsMoreOfOneStationNotMakeGoodForLessOfAnother) {
  Begin(500);
  Watch(0, "load_1", 500, 10'495, 60.0);
  Watch(1, "load_2", 500, 10'495, 60.0);
  End(10'500);
  EXPECT_EQ(tally_.frames(), 2 * 600u);
  EXPECT_EQ(tally_.lost(), 2 * kDue);
}

TEST_F(TallyOfFrames, TakesAPoseThatIsShownAgainForNoFrame) {
  Begin(500);
  for (const std::size_t viewer : {0, 1}) Watch(viewer, "load_1", 500, 10'495);
  Watch(0, "load_2", 500, 10'495);
  for (int i = 0; i < 300; ++i) Get(1, "load_2", 600);  // its server no longer hears it
  End(10'500);
  EXPECT_EQ(tally_.lost(), kDue - 1);
}

TEST_F(TallyOfFrames, HoldsNothingDueOfAStationThatSendsNothing) {
  Begin(0);
  End(0);
  EXPECT_EQ(tally_.due(), 0u);
  EXPECT_EQ(tally_.lost(), 0u);
}

TEST_F(TallyOfFrames, TakesTheAgeFromWhenTheStationSampledThePose) {
  Begin(500);
  for (int i = 0; i < 99; ++i) Get(0, "load_2", 1000 + 33u * static_cast<unsigned>(i), 10);
  Get(0, "load_2", 1000 + 33 * 99, 40);
  EXPECT_EQ(tally_.age().count(), 100u);
  EXPECT_NEAR(static_cast<double>(tally_.age().Quantile(0.5)), 10.0 * kMs, 0.4 * kMs);
  EXPECT_EQ(tally_.age().max(), 40u * kMs);
}

TEST_F(TallyOfFrames, CountsAFrameThatItsStationHasForgottenAsOldAsThatMakesIt) {
  Begin(6000);
  Get(0, "load_1", 1500, 5000);
  EXPECT_EQ(tally_.age().count(), 1u);
  EXPECT_EQ(tally_.age().max(), static_cast<std::uint64_t>(FrameTally::kForgotten_ns));
}

TEST_F(TallyOfFrames, CountsWhatComesBetweenItsBeginAndItsEnd) {
  Get(0, "load_1", 1);
  Begin(1000);
  Get(0, "load_1", 1033);
  End(2000);
  Get(0, "load_1", 2033);
  EXPECT_EQ(tally_.frames(), 1u);
  EXPECT_EQ(tally_.age().count(), 1u);
}

TEST_F(TallyOfFrames, CountsOtherStationsFramesAndNoMoreOfThem) {
  Begin(0);
  for (const std::string name :
       {"hand", "load", "load_", "load_0", "load_3", "load_1x", "loads_1", ""}) {
    Get(0, name, 100);
    Get(0, name, 9000);
  }
  End(10'000);
  EXPECT_EQ(tally_.frames(), 16u);
  EXPECT_EQ(tally_.lost(), tally_.due());
  EXPECT_EQ(tally_.age().count(), 0u);
}

}  // namespace
}  // namespace palpate
