#include "client/replayer/play/playback_clock.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(PlaybackClock, GoesWithTheClockTimesARate) {
  PlaybackClock clock(0.5, false);
  clock.Begin(1000, 50);
  EXPECT_EQ(clock.At(50), 1000);
  EXPECT_EQ(clock.At(70), 1010);
}

TEST(PlaybackClock, StandsWhilePausedAndGoesOnFromThere) {
  PlaybackClock clock(2.0, false);
  clock.Begin(1000, 0);
  clock.SetPaused(true, 10);
  EXPECT_TRUE(clock.paused());
  EXPECT_EQ(clock.At(500), 1020);
  clock.SetPaused(false, 500);
  EXPECT_EQ(clock.At(501), 1022);
}

TEST(PlaybackClock, GoesOnFromWhereItIsAtAnotherRate) {
  PlaybackClock clock(1.0, false);
  clock.Begin(1000, 0);
  clock.SetRate(4.0, 10);
  EXPECT_EQ(clock.rate(), 4.0);
  EXPECT_EQ(clock.At(10), 1010);
  EXPECT_EQ(clock.At(20), 1050);
  clock.SetPaused(true, 20);
  clock.SetRate(0.5, 30);
  EXPECT_EQ(clock.At(1000), 1050) << "still paused";
}

TEST(PlaybackClock, StepsToWhereItIsTold) {
  PlaybackClock clock(1.0, true);
  clock.Begin(1000, 0);
  clock.Begin(1500, 7);
  EXPECT_EQ(clock.At(100), 1500);
}

}  // namespace
}  // namespace palpate
