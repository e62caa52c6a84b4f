#include "client/load/capacity_report.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

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
