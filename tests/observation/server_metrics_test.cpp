#include "server/observation/server_metrics.h"

#include <regex>
#include <sstream>

#include <gmock/gmock.h>

#include "common/revision.h"
#include "common/step_fault.h"
#include "tests/common/recording/samples.h"
#include "tests/support/approved.h"

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

  /// Without what each build and each run says of itself.
  static std::string Lasting(const std::string& text) {
    std::istringstream in(text);
    std::string lasting;
    for (std::string line; std::getline(in, line);) {
      if (!std::regex_search(line, std::regex("^palpate_server_(build|start|resident)"))) {
        lasting += line + "\n";
      }
    }
    return lasting;
  }

  ServerMetrics metrics_{{dds::Transport::kUdp, "UDP (as asked)"},
                         {.fifo = true, .memory_locked = false, .pinned = false, .summary = ""}};
};

TEST_F(ServerMetricsTest, TellWhichBuildRuns) {
  EXPECT_THAT(Text(), HasSubstr(std::string("palpate_server_build_info{version=\"" PALPATE_VERSION
                                            "\",physics=\"") +
                                kPhysicsRevision + "\"} 1\n"));
}

TEST_F(ServerMetricsTest, AreAsPeopleHaveApprovedAtEachMoment) {
  metrics_.OnStatistics(Second("stranger"));
  EXPECT_THAT(Text(), Not(HasSubstr("stranger"))) << "without a session";
  Tell("left", 1, palpate_SESSION_WAITING);
  Tell("left", 1, palpate_SESSION_WAITING);  // asked again, so told again
  Tell("left", 1, palpate_SESSION_ACTIVE);
  Tell("right", 2, palpate_SESSION_ACQUIRING);
  Tell("left", 9, palpate_SESSION_ENDED);  // a former run
  Tell("other", 3, palpate_SESSION_REFUSED);
  metrics_.OnStatistics(Second("left"));
  metrics_.OnStatistics(Second("left"));
  std::string text = "## one session is active, another begins\n" + Text();
  Tell("left", 1, palpate_SESSION_ENDED);
  Tell("right", 2, palpate_SESSION_ACTIVE, true);
  Tell("third", 4, palpate_SESSION_HELD);
  metrics_.OnUntold(500);
  text += "## one has ended, the other is muted, a third is held, and 500 were refused\n" + Text();
  test::ExpectApproved("tests/observation/server_metrics.txt", Lasting(text));
  Tell("right", 2, palpate_SESSION_ACTIVE, false);
  EXPECT_THAT(Text(), HasSubstr("palpate_server_muted_sessions 0\n"));
}

}  // namespace
}  // namespace palpate::test
