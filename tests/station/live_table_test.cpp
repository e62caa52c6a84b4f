#include "client/station/live_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/step_fault.h"

namespace palpate {
namespace {

using testing::AllOf;
using testing::HasSubstr;

StationView View() {
  StationView view;
  view.seconds = 12.4;
  view.phase = "active";
  StationSnapshot& s = view.snapshot;
  s.rate_hz = 999.7;
  s.round_trip_us_p50 = 27.4;
  s.round_trip_us_p99 = 64.0;
  s.server_step_us_p50 = 3.14;
  s.replies = 250;
  s.contacts = 4;
  s.force_N = s.peak_force_N = 1.42;
  s.torque_Nm = 0.031;
  s.late = 2;
  s.lost = 1;
  s.activity = "slide";
  return view;
}

TEST(LiveTable, TellsAMomentInALine) {
  const std::string line = LiveTable::Line(View());
  for (const char* part : {"12.4 s", "1000 Hz", "27/64 us", "3.1 us", "contacts 4", "1.42 N",
                           "0.031 N m", "late 2", "lost 1", "active", "slide"}) {
    EXPECT_THAT(line, HasSubstr(part));
  }
}

TEST(LiveTable, LetsNoServerCommandTheTerminal) {
  StationView view = View();
  view.phase = "refused: a\nready\x1b[2J";
  EXPECT_THAT(LiveTable::Line(view), HasSubstr(R"(refused: a\nready\x1b[2J)"));
  for (const std::string& line : LiveTable(stdout, LiveTable::Style::kLines).Lines(view)) {
    EXPECT_THAT(line, testing::Not(HasSubstr("\x1b[2J")));
  }
}

TEST(LiveTable, ShowsNoTimesWhereNoReplyCame) {
  StationView view = View();
  view.snapshot.replies = 0;
  EXPECT_THAT(LiveTable::Line(view), HasSubstr("round trip -/- us"));
}

TEST(LiveTable, NamesFaultsAndAFadedForce) {
  StationView view = View();
  view.snapshot.faults = kFaultJammed | kFaultRowsFull;
  view.snapshot.fading = true;
  LiveTable table(stdout, LiveTable::Style::kInPlace);
  EXPECT_THAT(table.Lines(view).back(), AllOf(HasSubstr("rows full (more contacts"),
                                              HasSubstr("surfaces), force held back")));
}

TEST(LiveTable, GrowsItsScaleWithTheForce) {
  LiveTable table(stdout, LiveTable::Style::kInPlace);
  StationView view = View();
  EXPECT_THAT(table.Lines(view), testing::Contains(HasSubstr(" 2 N")));
  view.snapshot.peak_force_N = 7.0;
  EXPECT_THAT(table.Lines(view), testing::Contains(HasSubstr(" 10 N")));
  view.snapshot.peak_force_N = 0.0;
  EXPECT_THAT(table.Lines(view), testing::Contains(HasSubstr(" 10 N")));
}

TEST(LiveTable, DrawsOverItsFormerSelf) {
  std::FILE* file = std::tmpfile();
  LiveTable table(file, LiveTable::Style::kInPlace);
  table.Show(View());
  const long once = std::ftell(file);
  table.Show(View());
  std::string text(static_cast<std::size_t>(std::ftell(file)), '\0');
  std::rewind(file);
  ASSERT_EQ(std::fread(text.data(), 1, text.size(), file), text.size());
  std::fclose(file);
  EXPECT_EQ(text.find("\x1b[9A"), static_cast<std::size_t>(once));
}

TEST(Bar, FillsItsShareToAnEighthOfACell) {
  EXPECT_EQ(Bar(0.0, 1.0, 4), "····");
  EXPECT_EQ(Bar(0.5, 1.0, 4), "██··");
  EXPECT_EQ(Bar(0.125, 1.0, 4), "▌···");
  EXPECT_EQ(Bar(9.0, 1.0, 4), "████");
  EXPECT_EQ(Bar(-1.0, 1.0, 4), "····");
}

TEST(Sparkline, RisesWithItsValues) {
  EXPECT_EQ(Sparkline({0.0, 0.1, 0.5, 1.0}, 1.0), " ▁▄█");
}

}  // namespace
}  // namespace palpate
