#include "client/load/capacity.h"

#include <algorithm>
#include <optional>
#include <set>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"

namespace palpate {
namespace {

TEST(CapacitySearch, FindsEveryLimitBelowTheMost) {
  for (std::size_t most = 1; most <= 40; ++most) {
    for (std::size_t limit = 0; limit <= most; ++limit) {
      const Capacity found = FindCapacity(most, 1, [limit](std::size_t n) { return n <= limit; });
      EXPECT_EQ(found.holds, limit) << most;
      EXPECT_EQ(found.fails, limit == most ? 0 : limit + 1) << most;
    }
  }
}

TEST(CapacitySearch, DoublesAndThenBisects) {
  std::vector<std::size_t> tried;
  FindCapacity(1000, 1, [&](std::size_t n) {
    tried.push_back(n);
    return n <= 21;
  });
  EXPECT_THAT(tried, testing::ElementsAre(1, 2, 4, 8, 16, 32, 24, 20, 22, 21));
}

TEST(CapacitySearch, TriesNothingBeyondTheMost) {
  std::vector<std::size_t> tried;
  const Capacity found = FindCapacity(6, 1, [&](std::size_t n) {
    tried.push_back(n);
    return true;
  });
  EXPECT_THAT(tried, testing::ElementsAre(1, 2, 4, 6));
  EXPECT_EQ(found.holds, 6u);
  EXPECT_EQ(FindCapacity(0, 1, [](std::size_t) { return true; }).holds, 0u);
}

TEST(CapacitySearch, BelievesALoadThatFailsOnlyWhenItFailsAgain) {
  int bad_moments = 2;
  const auto holds = [&](std::size_t n) { return n != 8 ? n <= 12 : --bad_moments < 0; };
  EXPECT_EQ(FindCapacity(100, 3, holds).holds, 12u);
  bad_moments = 3;
  EXPECT_EQ(FindCapacity(100, 3, holds).holds, 7u);
}

TEST(CapacitySearch, LetsThroughWhatARunThrows) {
  EXPECT_THROW(FindCapacity(8, 2, [](std::size_t) -> bool { throw Error("no server"); }), Error);
}

/// Of n stations, of which one pose in ten is late, or none.
LoadFigures Figures(std::size_t n, bool holds) {
  LoadFigures figures;
  figures.stations = n;
  StationTotals totals;
  totals.ticks = 1001;
  totals.replies = 1000;
  totals.late = holds ? 0 : 100;
  figures.sum.Add(totals, 0, 0);
  return figures;
}

TEST(CapacitySearch, GivesTheFiguresOfTheNumbersThatItNames) {
  // Of 1, 2, 4, 3: three fails once, after four has failed twice, and then holds.
  std::set<std::size_t> tried;
  const FoundLoad found = FindLoad(10, 2, [&](std::size_t n) {
    return Figures(n, n < 3 || (n == 3 && !tried.insert(n).second));
  });
  EXPECT_EQ(found.capacity.holds, 3u);
  EXPECT_EQ(found.capacity.fails, 4u);
  ASSERT_TRUE(found.held && found.failed);
  EXPECT_EQ(found.held->stations, 3u);
  EXPECT_EQ(found.failed->stations, 4u);
  EXPECT_EQ(found.refusal, "");
}

TEST(CapacitySearch, NamesWhatServerOrGatewayDidNotTake) {
  const FoundLoad found = FindLoad(10, 2, [](std::size_t n) {
    if (n > 5) throw Error("no more than 5");
    return Figures(n, true);
  });
  EXPECT_EQ(found.capacity.holds, 5u);
  EXPECT_EQ(found.capacity.fails, 6u);
  EXPECT_EQ(found.refusal, "no more than 5");
  EXPECT_FALSE(found.failed);
}

TEST(CapacitySearch, ForgetsARefusalWhereLessFailsByItself) {
  const FoundLoad found = FindLoad(10, 1, [](std::size_t n) {
    if (n > 5) throw Error("no more than 5");
    return Figures(n, n < 5);
  });
  EXPECT_EQ(found.capacity.fails, 5u);
  ASSERT_TRUE(found.failed);
  EXPECT_EQ(found.failed->stations, 5u);
  EXPECT_EQ(found.refusal, "");
}

TEST(CapacitySearch, LetsThroughWhyNotEvenOneCanBeRun) {
  EXPECT_THROW(
      FindLoad(8, 2, [](std::size_t) -> std::optional<LoadFigures> { throw Error("no server"); }),
      Error);
}

using testing::HasSubstr;

LoadFigures ARun() {
  LoadFigures f;
  f.stations = 4;
  f.viewers = 50;
  f.stalled = 1;
  f.transport = "UDP";
  f.load_averages = "0.10 0.20 0.30";
  StationTotals totals;
  totals.ticks = 1001;
  totals.replies = 1000;
  totals.late = 5;
  f.sum.Add(totals, 0, 0);
  f.viewer_frames = 1500;
  f.lost = 2;
  f.frame_age.Add(9'000'000);
  f.server = ProcessUse{0.5, 0.4, "recvUC"};
  f.machine_busy = 0.6;
  return f;
}

TEST(CapacityReport, HasALineForEachRunWithAsManyCellsAsTheHeading) {
  CapacityReport report;
  report.runs = {ARun(), ARun()};
  const std::string text = ToMarkdown(report);
  const std::size_t heading = text.find("| stations |");
  ASSERT_NE(heading, std::string::npos);
  const std::string line = text.substr(heading, text.find('\n', heading) - heading);
  const std::string row = TableRow(report.runs[0]);
  EXPECT_EQ(std::ranges::count(line, '|'), std::ranges::count(row, '|'));
  EXPECT_NE(text.find(row + row), std::string::npos);
  EXPECT_THAT(row, HasSubstr("| 4 | 50 + 1 stalled | 1000.0 | 0.500 % |"));
  EXPECT_THAT(row, HasSubstr("| 1500 | 2 | 9.0 / 9.0 / 9.0 | 0.50 / - |"));
}

TEST(CapacityReport, SaysWhereAndHowItWasMeasuredAndWhatSetTheLimit) {
  CapacityReport report;
  report.machine = {"A Processor", 2, "GCC, optimised"};
  report.time = "2026-01-02 03:04 UTC";
  report.command = "palpate-load --find";
  report.realtime = "SCHED_FIFO 40";
  report.limits = {"20 stations: one thread"};
  const std::string text = ToMarkdown(report);
  for (const std::string what :
       {"A Processor", "| cores | 2 |", "2026-01-02 03:04 UTC", "palpate-load --find",
        "SCHED_FIFO 40", "20 stations: one thread"}) {
    EXPECT_THAT(text, HasSubstr(what));
  }
}

}  // namespace
}  // namespace palpate
