#include "client/load/load_figures.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

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

}  // namespace
}  // namespace palpate
