#include "client/station/summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/complaint.h"

namespace palpate {
namespace {

using testing::HasSubstr;

StationSummary Summary() {
  StationSummary summary;
  summary.station = "hand";
  summary.scene = "cube";
  summary.device = "still";
  summary.transport = "UDP";
  summary.seconds = 2.5;
  summary.linked_ticks_s = 2.0;
  summary.totals.ticks = summary.totals.sent = 1990;
  summary.totals.replies = 1000;
  summary.totals.late = 10;
  summary.totals.contact_replies = 250;
  summary.totals.max_force_N = 3.25;
  summary.limits.force_N = 22.0;
  summary.limits.continuous_torque_Nm = 0.188;
  summary.totals.evaluations = 398;
  summary.totals.beyond_region = 199;
  for (int i = 0; i < 1000; ++i) summary.totals.round_trip.Add(30'000);
  return summary;
}

TEST(StationSummary, TellsPeopleTheFiguresOfTheRun) {
  const std::string text = ToText(Summary());
  EXPECT_THAT(text, HasSubstr("995.0 Hz"));
  EXPECT_THAT(text, HasSubstr("late         10 (1.00 % over 1 ms)"));
  EXPECT_THAT(text, HasSubstr("at most 3.25 N"));
  EXPECT_THAT(text, HasSubstr("25 % of the time in contact"));
  EXPECT_THAT(text, HasSubstr("20 % of the ticks by rows, 50.0 % of these beyond their region"));
  EXPECT_THAT(text, HasSubstr("faults       none"));
}

TEST(StationSummary, TellsProgramsTheSame) {
  const nlohmann::json json = nlohmann::json::parse(ToJson(Summary()));
  EXPECT_EQ(json["rate_hz"], 995.0);
  EXPECT_EQ(json["late_fraction"], 0.01);
  EXPECT_EQ(json["force_N_max"], 3.25);
  EXPECT_EQ(json["rtt_us"]["p50"], 30.0);
  EXPECT_EQ(json["limits"]["force_N"], 22.0);
  EXPECT_EQ(json["limits"]["continuous_torque_Nm"], 0.188);
  EXPECT_EQ(json["limiter"]["fades"], 0);
  EXPECT_EQ(json["local_model"]["ticks"], 1990);
  EXPECT_EQ(json["local_model"]["evaluations"], 398);
  EXPECT_EQ(json["local_model"]["beyond_region"], 199);
}

TEST(StationSummary, NamesAFileThatCannotBeWritten) {
  EXPECT_THAT(test::ComplaintOf([] { WriteJson(Summary(), "/nowhere/run.json"); }),
              HasSubstr("--json /nowhere/run.json"));
}

}  // namespace
}  // namespace palpate
