#include "server/observation/server_metrics.h"

#include <gmock/gmock.h>

#include "common/revision.h"
#include "common/step_fault.h"
#include "tests/common/recording/samples.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;
using testing::Not;

class ServerMetricsTest : public testing::Test {
 protected:
  void Tell(const std::string& station, std::uint64_t run, wire::SessionPhase phase,
            bool muted = false) {
    wire::SessionState state = SampleState(station, run);
    state.phase = phase;
    state.muted = muted;
    metrics_.OnSession(state);
  }
  static wire::LoopStatistics Second(const std::string& station) {
    wire::LoopStatistics s{};
    wire::FromText(station, s.station);
    wire::FromText("cube", s.scene);
    s.rate_hz = 999.5;
    s.steps = 1000;
    s.step_us_p50 = 3.0;
    s.step_us_max = 250.0;
    s.late = 2;
    s.lost = 1;
    s.rejected_speed = 4;
    s.contacts = 5;
    s.faults = kFaultJammed;
    return s;
  }
  std::string Text() const {
    MetricsPage page;
    metrics_.Fill(page);
    return page.ToText();
  }

  ServerMetrics metrics_{{dds::Transport::kUdp, "UDP (as asked)"},
                         {.fifo = true, .memory_locked = false, .pinned = false, .summary = ""}};
};

TEST_F(ServerMetricsTest, TellsHowTheServerRuns) {
  const std::string text = Text();
  EXPECT_THAT(text, HasSubstr(std::string("palpate_server_build_info{version=\"" PALPATE_VERSION
                                          "\",physics=\"") +
                              kPhysicsRevision + "\"} 1\n"));
  EXPECT_THAT(
      text,
      HasSubstr(R"x(palpate_server_transport_info{transport="udp",reason="UDP (as asked)"} 1)x"));
  EXPECT_THAT(text, HasSubstr(R"(palpate_server_realtime{grant="fifo"} 1)"));
  EXPECT_THAT(text, HasSubstr(R"(palpate_server_realtime{grant="memory"} 0)"));
}

TEST_F(ServerMetricsTest, CountsSessionsByTheirPhaseAndRun) {
  Tell("left", 1, palpate_SESSION_WAITING);
  Tell("left", 1, palpate_SESSION_WAITING);  // asked again, so told again
  Tell("left", 1, palpate_SESSION_ACTIVE);
  Tell("right", 2, palpate_SESSION_ACQUIRING);
  Tell("left", 9, palpate_SESSION_ENDED);  // a former run
  Tell("other", 3, palpate_SESSION_REFUSED);
  std::string text = Text();
  EXPECT_THAT(text, HasSubstr(R"(palpate_server_sessions{phase="active"} 1)"));
  EXPECT_THAT(text, HasSubstr(R"(palpate_server_sessions{phase="acquiring"} 1)"));
  EXPECT_THAT(text, HasSubstr(R"(palpate_server_sessions{phase="waiting"} 0)"));
  EXPECT_THAT(text, HasSubstr("palpate_server_sessions_begun_total 2\n"));
  EXPECT_THAT(text, HasSubstr("palpate_server_sessions_ended_total 0\n"));
  EXPECT_THAT(text, HasSubstr("palpate_server_refusals_total 1\n"));
  Tell("left", 1, palpate_SESSION_ENDED);
  text = Text();
  EXPECT_THAT(text, HasSubstr(R"(palpate_server_sessions{phase="active"} 0)"));
  EXPECT_THAT(text, HasSubstr("palpate_server_sessions_ended_total 1\n"));
}

TEST_F(ServerMetricsTest, CountsWhoIsHeldMutedOrRefusedWithoutAWord) {
  Tell("left", 1, palpate_SESSION_HELD);
  EXPECT_THAT(Text(), HasSubstr("palpate_server_held_requests_total 1\n"));
  EXPECT_THAT(Text(), HasSubstr("palpate_server_sessions_begun_total 0\n"));
  Tell("left", 1, palpate_SESSION_ACTIVE, true);
  EXPECT_THAT(Text(), HasSubstr("palpate_server_muted_sessions 1\n"));
  Tell("left", 1, palpate_SESSION_ACTIVE, false);
  EXPECT_THAT(Text(), HasSubstr("palpate_server_muted_sessions 0\n"));
  metrics_.OnUntold(500);
  EXPECT_THAT(Text(), HasSubstr("palpate_server_refusals_total 500\n"));
}

TEST_F(ServerMetricsTest, AddsUpASessionsSecondsAsLongAsItLasts) {
  metrics_.OnStatistics(Second("stranger"));
  EXPECT_THAT(Text(), Not(HasSubstr("stranger"))) << "without a session";
  Tell("left", 1, palpate_SESSION_ACTIVE);
  metrics_.OnStatistics(Second("left"));
  metrics_.OnStatistics(Second("left"));
  const std::string text = Text();
  const std::string of = R"({station="left",scene="cube")";
  EXPECT_THAT(text, HasSubstr("palpate_server_steps_total" + of + "} 2000\n"));
  EXPECT_THAT(text, HasSubstr("palpate_server_late_poses_total" + of + "} 4\n"));
  EXPECT_THAT(text, HasSubstr("palpate_server_lost_poses_total" + of + "} 2\n"));
  EXPECT_THAT(text,
              HasSubstr("palpate_server_rejected_poses_total" + of + ",reason=\"speed\"} 8\n"));
  EXPECT_THAT(text, HasSubstr("palpate_server_pose_rate_hertz" + of + "} 999.5\n"));
  EXPECT_THAT(text, HasSubstr("palpate_server_contacts" + of + "} 5\n"));
  EXPECT_THAT(text, HasSubstr("palpate_server_fault" + of + ",fault=\"jammed\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("palpate_server_fault" + of + ",fault=\"unsolved\"} 0\n"));
  EXPECT_THAT(text, testing::ContainsRegex(
                        "palpate_server_step_seconds" +
                        std::string(R"(\{station="left",scene="cube",quantile="1"\} 0.00025)")));
  Tell("left", 1, palpate_SESSION_ENDED);
  EXPECT_THAT(Text(), Not(HasSubstr("left")));
}

}  // namespace
}  // namespace palpate::test
