// The dashboard and the alerts against what the real programs expose.
#include <csignal>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/common/recording/samples.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"
#include "tests/support/test_domain.h"
#include "tests/support/web_client.h"

namespace palpate::test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

using Names = std::set<std::string>;

Names MetricsIn(const std::string& text) {
  static const std::regex kName("palpate_(server|gateway)_[a-z0-9_]+");
  Names names;
  for (std::sregex_iterator it(text.begin(), text.end(), kName), end; it != end; ++it) {
    names.insert(it->str());
  }
  return names;
}

/// The names of the metrics with a value.
Names MetricsOn(const std::string& page) {
  Names names;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with('#')) names.merge(MetricsIn(line.substr(0, line.find_first_of("{ "))));
  }
  return names;
}

Names Without(const Names& these, const Names& those) {
  Names rest;
  std::ranges::set_difference(these, those, std::inserter(rest, rest.end()));
  return rest;
}

/// The port in the program's output after `before`.
int PortAfter(Program& program, const std::string& before) {
  if (!program.Says(before, 60.0) || !program.Says("/", 5.0)) return 0;
  const std::string& said = program.Output();
  return std::atoi(said.c_str() + said.find(before) + before.size());
}

const std::string kFolder = PALPATE_SOURCE_DIR "/deploy/observability";

class DashboardTest : public testing::Test {
 protected:
  const std::string domain_ = std::to_string(OwnDomain());
  Folder folder_;
  std::string events_ = folder_ / "events.jsonl";
  Program server_{PALPATE_BIN_DIR "/palpate-server",
                  {"--scene", "cube", "--transport", "udp", "--domain", domain_, "--metrics", "0",
                   "--event-log", events_}};
  Program viewer_{PALPATE_BIN_DIR "/palpate-viewer", {"--http", "0", "--domain", domain_}};
};

TEST_F(DashboardTest, ShowsWhatServerAndGatewayExposeAndNothingElse) {
  const int server_port = PortAfter(server_, "metrics: http://127.0.0.1:");
  const int viewer_port = PortAfter(viewer_, "page http://127.0.0.1:");
  ASSERT_GT(server_port, 0) << server_.Output();
  ASSERT_GT(viewer_port, 0) << viewer_.Output();
  ASSERT_TRUE(server_.Says("ready: ", 60.0)) << server_.Output();
  Program station(PALPATE_BIN_DIR "/palpate-station",
                  {"--device", "simulated", "--scene", "cube", "--id", "left", "--transport", "udp",
                   "--domain", domain_, "--for", "60"});
  // A station's first statistics come with its first full second.
  ASSERT_TRUE(server_.Says("left ", 60.0)) << server_.Output();

  const HttpAnswer server = Get(server_port, "/metrics");
  const HttpAnswer gateway = Get(viewer_port, "/metrics");
  ASSERT_EQ(server.status, 200);
  ASSERT_EQ(gateway.status, 200);
  EXPECT_THAT(gateway.headers.at("content-type"), HasSubstr("version=0.0.4"));
  EXPECT_THAT(server.body, HasSubstr(R"(palpate_server_sessions{phase="active"} 1)"));
  EXPECT_THAT(server.body, HasSubstr(R"(palpate_server_contacts{station="left",scene="cube"})"));
  Names exposed = MetricsOn(server.body);
  exposed.merge(MetricsOn(gateway.body));
  EXPECT_GT(exposed.size(), 25u);

  const std::string dashboard = ReadWholeFile(kFolder + "/grafana-dashboard.json");
  EXPECT_TRUE(nlohmann::json::accept(dashboard));
  const Names shown = MetricsIn(dashboard),
              alerts = MetricsIn(ReadWholeFile(kFolder + "/alerts.yml"));
  EXPECT_THAT(Without(shown, exposed), IsEmpty()) << "shown, and exposed by nobody";
  EXPECT_THAT(Without(alerts, exposed), IsEmpty()) << "watched, and exposed by nobody";
  EXPECT_THAT(Without(exposed, shown), IsEmpty()) << "exposed, and shown nowhere";
  Names named = MetricsIn(ReadWholeFile(PALPATE_SOURCE_DIR "/common/metrics/metric.h"));
  EXPECT_EQ(named, exposed);

  station.Signal(SIGINT);
  EXPECT_EQ(station.Exit(), 0) << station.Output();
  ASSERT_TRUE(server_.Says("left: ended", 20.0)) << server_.Output();
  server_.Signal(SIGINT);
  EXPECT_EQ(server_.Exit(), 0) << server_.Output();
  std::vector<std::string> events;
  std::istringstream lines(ReadWholeFile(events_));
  for (std::string line; std::getline(lines, line);) {
    events.push_back(nlohmann::json::parse(line)["event"]);
  }
  for (const char* event : {"start", "begun", "active", "ended", "stop"}) {
    EXPECT_THAT(events, Contains(event));
  }
}

TEST(ServerMetricsPort, TakesNoNameOfAHostWithoutAPortToAskAt) {
  Program server(
      PALPATE_BIN_DIR "/palpate-server",
      {"--scene", "cube", "--domain", std::to_string(OwnDomain()), "--host-name", "lab"});
  EXPECT_EQ(server.Exit(), 2);
  EXPECT_THAT(server.Output(), HasSubstr("--host-name needs --metrics"));
}

}  // namespace
}  // namespace palpate::test
