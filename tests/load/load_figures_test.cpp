#include "client/load/load_figures.h"

#include <gtest/gtest.h>

#include "tests/support/approved.h"

namespace palpate {
namespace {

/// The figures of a station that ran for `ticks`.
StationTotals Totals(std::uint64_t ticks, std::uint64_t replies, std::uint64_t late) {
  StationTotals totals;
  totals.ticks = totals.sent = ticks;
  totals.replies = replies;
  totals.late = late;
  for (std::uint64_t i = 0; i < replies; ++i) {
    totals.round_trip.Add(i < replies - late ? 100'000 : 2'000'000);
  }
  return totals;
}

LoadFigures TwoStations() {
  LoadFigures f;
  f.stations = 2;
  f.viewers = 3;
  f.seconds = 1.0;
  f.transport = "UDP";
  f.sum.Add(Totals(1001, 1000, 0), 0, 0);
  f.sum.Add(Totals(801, 760, 10), 200, 1);
  f.viewer_frames = 99;
  f.frames_due = 100;
  f.lost = 1;
  f.frame_age.Add(9'000'000);
  f.server = 0.5;
  return f;
}

TEST(LoadFigures, CallLateWhatIsNotAnsweredInItsMillisecondWhoeverIsAtFault) {
  const StationSum sum = TwoStations().sum;
  // Of 2000 poses some had late replies, some none, and some were never sent.
  EXPECT_DOUBLE_EQ(sum.late_fraction(), (10 + 40 + 200) / 2000.0);
  EXPECT_DOUBLE_EQ(sum.worst_late_fraction, 250 / 1000.0);
  EXPECT_DOUBLE_EQ(sum.hz(), 1000.0 * 1760 / 2000);
  EXPECT_DOUBLE_EQ(sum.worst_hz, 760.0);
  EXPECT_EQ(sum.missed_ticks, 200u);
  EXPECT_EQ(sum.reconnects, 1u);
  EXPECT_EQ(sum.round_trip.count(), 1760u);
}

TEST(LoadFigures, CallNoneLateWhereAllButTheLastPoseIsAnswered) {
  StationSum sum;
  sum.Add(Totals(1001, 1000, 0), 0, 0);
  EXPECT_EQ(sum.late_fraction(), 0.0);
  EXPECT_EQ(sum.hz(), 1000.0);
  EXPECT_EQ(StationSum().late_fraction(), 0.0);
}

TEST(LoadFigures, HoldWithLessThanAHundredthLateAndLost) {
  LoadFigures f;
  f.sum.Add(Totals(1001, 1000, 9), 0, 0);
  f.viewer_frames = 9000;  // most of them from others' stations
  f.frames_due = 1000;
  f.lost = 9;
  EXPECT_TRUE(Holds(f));
  f.lost = 10;
  EXPECT_FALSE(Holds(f));
  f.lost = 0;
  f.viewers_gone = 1;
  EXPECT_FALSE(Holds(f));
  f.viewers_gone = 0;
  f.sum.Add(Totals(1001, 1000, 30), 0, 0);
  EXPECT_FALSE(Holds(f));
}

TEST(LoadFigures, AreToldAsPeopleHaveApproved) {
  std::string text = "## two stations\n" + ToText(TwoStations()) + ToJson(TwoStations()) + "\n";
  LoadFigures f;
  f.viewers = 1;
  f.seconds = 1.0;
  text += "## a viewer alone\n" + ToText(f);
  f.sum.Add(Totals(1001, 1000, 9), 0, 0);
  f.frames_due = 1000;
  text += "## what holds\n" + ToText(f);
  f.sum.Add(Totals(1001, 1000, 21), 0, 0);
  f.lost = 20;
  f.viewers_gone = 2;
  text += "## what does not\n" + ToText(f) + ToJson(f) + "\n";
  test::ExpectApproved("tests/load/figures.txt", text);
}

}  // namespace
}  // namespace palpate
