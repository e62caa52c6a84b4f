#include "client/load/load_figures.h"

#include <algorithm>
#include <set>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "client/load/capacity.h"
#include "common/error.h"

namespace palpate {
namespace {

using testing::HasSubstr;

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
  f.server = ProcessUse{0.5, 0.4, "recvUC"};
  f.machine_busy = 0.6;
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

TEST(LoadFigures, EndWithWhetherTheLoadHoldsAndWhyNot) {
  LoadFigures f;
  f.sum.Add(Totals(1001, 1000, 9), 0, 0);
  f.frames_due = 1000;
  EXPECT_THAT(ToText(f), testing::EndsWith("\nholds\n"));
  EXPECT_EQ(nlohmann::json::parse(ToJson(f))["holds"], true);
  f.sum.Add(Totals(1001, 1000, 21), 0, 0);
  EXPECT_THAT(ToText(f), testing::EndsWith("\ndoes not hold, because 1.500 % of the poses were "
                                           "late, and 1 % is too much\n"));
  EXPECT_EQ(nlohmann::json::parse(ToJson(f))["holds"], false);
  f.lost = 20;
  f.viewers_gone = 2;
  EXPECT_THAT(VerdictText(f),
              HasSubstr("late, and 1 % is too much; 2.00 % of the frames were lost, "
                        "and 1 % is too much; 2 viewers are gone"));
}

TEST(LoadFigures, NameTheThreadThatFillsACore) {
  LoadFigures f = TwoStations();
  f.server = ProcessUse{1.1, 0.95, "recvUC"};
  f.self = {0.5, 0.1, "palpate-load"};
  EXPECT_THAT(LimitingResource(f, 2), HasSubstr("one thread of palpate-server (recvUC)"));
}

TEST(LoadFigures, NameTheCoresAndWhoUsesThem) {
  LoadFigures f = TwoStations();
  f.machine_busy = 0.97;
  f.self = {1.3, 0.1, "palpate-load"};
  const std::string all = LimitingResource(f, 2);
  EXPECT_THAT(all, HasSubstr("2 cores, 97 % busy"));
  EXPECT_THAT(all, HasSubstr("palpate-load 1.30, palpate-server 0.50, all else 0.14"));
  f.self = {0.1, 0.1, "palpate-load"};
  EXPECT_THAT(LimitingResource(f, 2), HasSubstr("other programs"));
  f.machine_busy = 0.4;
  EXPECT_THAT(LimitingResource(f, 2), HasSubstr("no core is full"));
}

TEST(LoadFigures, AreJsonWithTheKeysThatProgramsLookFor) {
  const nlohmann::json json = nlohmann::json::parse(ToJson(TwoStations()));
  EXPECT_EQ(json["stations"], 2);
  EXPECT_EQ(json["viewers"], 3);
  EXPECT_EQ(json["seconds"], 1.0);
  EXPECT_EQ(json["achieved_hz"], 880.0);
  EXPECT_EQ(json["late_fraction"], 0.125);
  EXPECT_NEAR(json["rtt_us"]["p50"].get<double>(), 100.0, 4.0);
  EXPECT_NEAR(json["rtt_us"]["p999"].get<double>(), 2000.0, 1.0);
  EXPECT_NEAR(json["rtt_us"]["max"].get<double>(), 2000.0, 1e-9);
  EXPECT_EQ(json["server_cpu_fraction"], 0.5);
  EXPECT_TRUE(json["gateway_cpu_fraction"].is_null()) << "its process is not known";
  EXPECT_EQ(json["viewer_frames"], 99);
  EXPECT_EQ(json["frames_due"], 100);
  EXPECT_EQ(json["lost"], 1);
  EXPECT_EQ(json["frame_age_ms"]["max"], 9.0);
}

TEST(LoadFigures, TellPeopleWhatThereWas) {
  const std::string text = ToText(TwoStations());
  EXPECT_THAT(text, HasSubstr("2 stations, 3 viewers, 1.0 s"));
  EXPECT_THAT(text, HasSubstr("880.0 Hz, worst station 760.0 Hz, over UDP"));
  EXPECT_THAT(text, HasSubstr("12.500 %, worst station 25.000 %; 200 ticks missed, 1 reconnects"));
  EXPECT_THAT(text, HasSubstr("99 (33.0 a second and viewer), 1 lost"));
  LoadFigures viewers_only;
  viewers_only.viewers = 1;
  viewers_only.seconds = 1.0;
  EXPECT_THAT(ToText(viewers_only), testing::Not(HasSubstr("round trip")));
}

TEST(CapacitySearch, FindsEveryLimitBelowTheMost) {
  for (std::size_t most = 1; most <= 40; ++most) {
    for (std::size_t limit = 0; limit <= most; ++limit) {
      const Capacity found = FindCapacity(most, 1, [limit](std::size_t n) { return n <= limit; });
      EXPECT_EQ(found.holds, limit) << most;
      EXPECT_EQ(found.fails, limit == most ? 0 : limit + 1) << most;
    }
  }
}

TEST(CapacitySearch, DoublesThenBisectsAndTriesNothingBeyondTheMost) {
  const auto tried = [](std::size_t most, std::size_t limit) {
    std::vector<std::size_t> numbers;
    FindCapacity(most, 1, [&](std::size_t n) {
      numbers.push_back(n);
      return n <= limit;
    });
    return numbers;
  };
  EXPECT_THAT(tried(1000, 21), testing::ElementsAre(1, 2, 4, 8, 16, 32, 24, 20, 22, 21));
  EXPECT_THAT(tried(6, 6), testing::ElementsAre(1, 2, 4, 6));
  EXPECT_EQ(FindCapacity(0, 1, [](std::size_t) { return true; }).holds, 0u);
}

TEST(CapacitySearch, BelievesALoadThatFailsOnlyWhenItFailsAgain) {
  int bad_moments = 2;
  const auto holds = [&](std::size_t n) { return n != 8 ? n <= 12 : --bad_moments < 0; };
  EXPECT_EQ(FindCapacity(100, 3, holds).holds, 12u);
  bad_moments = 3;
  EXPECT_EQ(FindCapacity(100, 3, holds).holds, 7u);
}

/// The report on n stations with one late pose in ten, or none.
LoadFigures Figures(std::size_t n, bool holds) {
  LoadFigures figures;
  figures.stations = n;
  figures.sum.Add(Totals(1001, 1000, holds ? 0 : 100), 0, 0);
  return figures;
}

TEST(CapacitySearch, GivesTheFiguresOfTheNumbersThatItNames) {
  // Runs of 1, 2, 4 and 3 stations: four fails twice, three fails once and then holds.
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

TEST(CapacitySearch, LetsThroughWhatARunThrowsAndWhyNotEvenOneCanBeRun) {
  EXPECT_THROW(FindCapacity(8, 2, [](std::size_t) -> bool { throw Error("no server"); }), Error);
  EXPECT_THROW(
      FindLoad(8, 2, [](std::size_t) -> std::optional<LoadFigures> { throw Error("no server"); }),
      Error);
}

TEST(CapacityReport, HasALineForEachRunWithAsManyCellsAsTheHeading) {
  CapacityReport report;
  report.runs = {TwoStations(), TwoStations()};
  report.runs[0].stalled = report.runs[1].stalled = 1;
  const std::string text = ToMarkdown(report);
  const std::size_t heading = text.find("| stations |");
  ASSERT_NE(heading, std::string::npos);
  const std::string line = text.substr(heading, text.find('\n', heading) - heading);
  const std::string row = TableRow(report.runs[0]);
  EXPECT_EQ(std::ranges::count(line, '|'), std::ranges::count(row, '|'));
  EXPECT_NE(text.find(row + row), std::string::npos);
  EXPECT_THAT(row, HasSubstr("| 2 | 3 + 1 stalled | 880.0 | 12.500 % |"));
  EXPECT_THAT(row, HasSubstr("| 99 | 1 | 9.0 / 9.0 / 9.0 | 0.50 / - |"));
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
