// The real palpate-load beside a real server and gateway: it measures what is there, and says what
// is missing.
#include <csignal>
#include <cstdlib>
#include <memory>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/support/folder.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"
#include "tests/support/test_domain.h"

namespace palpate::test {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

const int kDomain = OwnDomain();

class Load : public testing::Test {
 protected:
  std::string In(const std::string& file) const { return folder_ / file; }
  std::string ReadText(const std::string& file) const { return ReadWholeFile(In(file)); }

  std::unique_ptr<Program> Start(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--domain", std::to_string(kDomain)});
    return std::make_unique<Program>(PALPATE_BIN_DIR "/palpate-load", std::move(arguments));
  }
  /// A server whose scene has four tools.
  void StartServer() {
    const auto make = Start({"--make-scene", "4", In("many.json")});
    ASSERT_EQ(make->Exit(), 0) << make->Output();
    server_ = std::make_unique<Program>(
        PALPATE_BIN_DIR "/palpate-server",
        std::vector<std::string>{"--scene", In("many.json"), "--realtime", "off", "--transport",
                                 "udp", "--domain", std::to_string(kDomain)});
    ASSERT_TRUE(server_->Says("ready: ", 60.0)) << server_->Output();
  }
  void StartGateway() {
    gateway_ =
        std::make_unique<Program>(PALPATE_BIN_DIR "/palpate-viewer",
                                  std::vector<std::string>{"--http", "0", "--max-viewers", "3",
                                                           "--domain", std::to_string(kDomain)});
    const std::string begin = "ready: page http://127.0.0.1:";
    ASSERT_TRUE(gateway_->Says(begin)) << gateway_->Output();
    ASSERT_TRUE(gateway_->Says("/; domain"));
    const std::string& said = gateway_->Output();
    url_ = "ws://127.0.0.1:" +
           std::to_string(std::atoi(said.c_str() + said.find(begin) + begin.size()));
  }
  std::vector<std::string> Arguments(const std::vector<std::string>& more,
                                     const std::string& seconds = "2") const {
    return Joined({"--scene", In("many.json"), "--realtime", "off", "--transport", "udp",
                   "--seconds", seconds},
                  more);
  }

  const Folder folder_;
  std::unique_ptr<Program> server_, gateway_;
  std::string url_;
};

TEST_F(Load, MeasuresStationsAndViewers) {
  StartServer();
  StartGateway();
  const auto load = Start(Arguments(
      {"--stations", "2", "--viewers", "3", "--viewer-url", url_, "--json", In("load.json")}));
  ASSERT_EQ(load->Exit(60.0), 0) << load->Output();
  const Json json = Json::parse(ReadText("load.json"));
  EXPECT_EQ(json["stations"], 2);
  EXPECT_EQ(json["viewers"], 3);
  EXPECT_GE(json["seconds"], 2.0);
  EXPECT_LE(json["achieved_hz"], 1000.0);
  EXPECT_LE(json["late_fraction"], 1.0);
  for (const std::string key : {"rtt_us", "frame_age_ms", "server_step_us"}) {
    const Json& group = json[key];
    EXPECT_GT(group["p50"], 0.0) << key;
    EXPECT_LE(group["p50"], group["p99"]) << key;
    EXPECT_LE(group["p99"], group["p999"]) << key;
    EXPECT_LE(group["p999"], group["max"]) << key;
  }
  for (const std::string key :
       {"achieved_hz", "server_cpu_fraction", "load_cpu_fraction", "viewer_frames"}) {
    EXPECT_GT(json[key], 0) << key;
  }
  for (const std::string key : {"late_fraction", "gateway_cpu_fraction", "lost"}) {
    EXPECT_GE(json[key], 0) << key;
  }
  EXPECT_EQ(json["viewers_gone"], 0);
  // Everything that it took is free again.
  EXPECT_TRUE(server_->Says("station load_2: ended")) << server_->Output();
}

TEST_F(Load, GoesOverTheNetworkAndToThePeersThatItIsGiven) {
  StartServer();
  const auto load =
      Start(Arguments({"--network", "lo", "--peer", "127.0.0.1", "--json", In("peer.json")}, "1"));
  ASSERT_EQ(load->Exit(60.0), 0) << load->Output();
  const Json json = Json::parse(ReadText("peer.json"));
  EXPECT_GT(json["achieved_hz"], 0.0);
}

TEST_F(Load, KeepsTheFiguresOfTheRunsBeforeOneThatFails) {
  StartServer();
  const auto load = Start(Arguments({"--stations", "1", "--viewers", "0,1", "--viewer-url",
                                     "ws://127.0.0.1:1", "--json", In("load.json")},
                                    "0.5"));
  EXPECT_EQ(load->Exit(60.0), 1);
  EXPECT_THAT(load->Output(), HasSubstr("no gateway answers at ws://127.0.0.1:1"));
  EXPECT_THAT(load->Output(), HasSubstr("palpate-viewer --http 1"));
  EXPECT_EQ(Json::parse(ReadText("load.json"))["viewers"], 0);
}

TEST_F(Load, NamesAFileThatItCannotWriteBeforeItMeasures) {
  const auto load = Start({"--json", In("nowhere/file"), "--wait", "0.1"});
  EXPECT_EQ(load->Exit(), 1);
  EXPECT_THAT(load->Output(), HasSubstr("--json " + In("nowhere/file")));
}

TEST_F(Load, NamesTheProgramThatDoesNotRun) {
  const auto no_server = Start({"--wait", "0.5"});
  EXPECT_EQ(no_server->Exit(), 1);
  EXPECT_THAT(no_server->Output(),
              HasSubstr("no server answers in domain " + std::to_string(kDomain)));
  EXPECT_THAT(no_server->Output(), HasSubstr("palpate-server --scene cube --domain"));
}

TEST_F(Load, NamesWhatTheServerDoesNotOffer) {
  StartServer();
  const auto tools = Start(Arguments({"--stations", "5"}));
  EXPECT_EQ(tools->Exit(), 1);
  EXPECT_THAT(tools->Output(), HasSubstr("--stations 5: the server offers 4 tools"));
  EXPECT_THAT(tools->Output(), HasSubstr("--make-scene 5"));
  StartGateway();
  const auto viewers = Start(Arguments({"--viewers", "4", "--viewer-url", url_}));
  EXPECT_EQ(viewers->Exit(), 1);
  EXPECT_THAT(viewers->Output(), HasSubstr("--max-viewers"));
}

TEST_F(Load, EndsCleanlyOnCtrlCWithWhatItHasMeasured) {
  StartServer();
  const auto load = Start(Arguments({"--stations", "2"}, "3600"));
  ASSERT_TRUE(load->Says("of 3600 s", 60.0)) << load->Output();
  load->Signal(SIGINT);
  EXPECT_EQ(load->Exit(), 0);
  EXPECT_THAT(load->Output(), HasSubstr("2 stations, 0 viewers"));
  EXPECT_TRUE(server_->Says("station load_1: ended")) << server_->Output();
  EXPECT_TRUE(server_->Says("station load_2: ended")) << server_->Output();
}

}  // namespace
}  // namespace palpate::test
