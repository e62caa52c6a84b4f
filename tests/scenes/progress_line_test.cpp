#include "scenes/progress_line.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::EndsWith;

TEST(ProgressText, SaysHowLongTheRestTakesOnceThereIsSomethingToTellItFrom) {
  double now = 1000.0;
  ProgressText text([&] { return now; });
  EXPECT_EQ(text("part: reading", 0.0), "  0 %  part: reading");
  now += 1.9;
  EXPECT_EQ(text("part: reading", 0.5), " 50 %  part: reading");
  now += 0.6;  // 2.5 s for half
  EXPECT_EQ(text("part: reading", 0.5), " 50 %  part: reading, about 3 s left");
  now += 1.5;  // the same stage goes on, so its estimate grows
  EXPECT_EQ(text("part: reading", 0.5), " 50 %  part: reading, about 4 s left");
  EXPECT_EQ(text("part: moving", 0.9), " 90 %  part: moving");  // 0.4 s is not worth mentioning
  EXPECT_EQ(text("done", 1.0), "100 %  done");
}

TEST(ProgressText, SaysNothingOfTheRestWhereHardlyAnythingIsDone) {
  double now = 0.0;
  ProgressText text([&] { return now; });
  text("a", 0.0);
  now = 60.0;
  EXPECT_EQ(text("a", 0.01), "  1 %  a");
  EXPECT_EQ(text("a", 0.02), "  2 %  a, about 49 min left");
}

TEST(ProgressText, IsCoarserTheLongerItTakes) {
  const auto left = [](double seconds) {
    double now = 0.0;
    ProgressText text([&] { return now; });
    text("a", 0.0);
    now = seconds;  // half is done: the rest takes as long
    return text("a", 0.5);
  };
  EXPECT_THAT(left(9.4), EndsWith("about 9 s left"));
  EXPECT_THAT(left(33.0), EndsWith("about 35 s left"));
  EXPECT_THAT(left(57.0), EndsWith("about 55 s left"));
  EXPECT_THAT(left(58.0), EndsWith("about 1 min left"));
  EXPECT_THAT(left(1000.0), EndsWith("about 17 min left"));
  EXPECT_THAT(left(9000.0), EndsWith("about 2.5 h left"));
}

TEST(ProgressText, BeginsAnewWithOtherWork) {
  double now = 0.0;
  ProgressText text([&] { return now; });
  text("one", 0.0);
  now = 100.0;
  text("one", 1.0);
  EXPECT_EQ(text("two", 0.0), "  0 %  two");
  now = 104.0;
  EXPECT_EQ(text("two", 0.5), " 50 %  two, about 4 s left");
}

TEST(ProgressLog, TellsOfLongWorkEveryFiveSecondsAndOfShortWorkNothing) {
  double now = 0.0;
  std::vector<std::string> told;
  ProgressLog log([&](const std::string& text) { told.push_back(text); }, [&] { return now; });
  for (int i = 0; i <= 4; ++i, now += 1.0) log("one", 0.25 * i);
  EXPECT_TRUE(told.empty());
  now = 100.0;
  for (int i = 0; i <= 11; ++i, now += 1.0) log("two", 0.05 * i);
  EXPECT_THAT(told, ElementsAre(" 25 %  two, about 15 s left", " 50 %  two, about 10 s left"));
}

}  // namespace
}  // namespace palpate
