// The real palpate-load beside a real server and gateway: it measures what is there, and says what
// is missing.
#include <csignal>
#include <cstdlib>
#include <map>
#include <memory>
#include <regex>

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

TEST_F(Load, MeasuresStationsAndViewersOfBothKinds) {
  StartServer();
  StartGateway();
  const auto load =
      Start(Arguments({"--stations", "2", "--viewers", "3", "--dds-viewers", "1", "--viewer-url",
                       url_, "--json", In("load.json"), "--report", In("capacity.md")}));
  ASSERT_EQ(load->Exit(60.0), 0) << load->Output();
  const Json json = Json::parse(ReadText("load.json"));
  EXPECT_EQ(json["stations"], 2);
  EXPECT_EQ(json["viewers"], 3);
  EXPECT_GE(json["seconds"], 2.0);
  EXPECT_LE(json["achieved_hz"], 1000.0);
  EXPECT_LE(json["late_fraction"], 1.0);
  for (const std::string key : {"rtt_us", "frame_age_ms", "dds_frame_age_ms", "server_step_us"}) {
    const Json& group = json[key];
    EXPECT_GT(group["p50"], 0.0) << key;
    EXPECT_LE(group["p50"], group["p99"]) << key;
    EXPECT_LE(group["p99"], group["p999"]) << key;
    EXPECT_LE(group["p999"], group["max"]) << key;
  }
  for (const std::string key : {"achieved_hz", "server_cpu_fraction", "load_cpu_fraction",
                                "viewer_frames", "dds_viewer_frames"}) {
    EXPECT_GT(json[key], 0) << key;
  }
  for (const std::string key : {"late_fraction", "gateway_cpu_fraction", "lost"}) {
    EXPECT_GE(json[key], 0) << key;
  }
  EXPECT_EQ(json["viewers_gone"], 0);
  EXPECT_THAT(ReadText("capacity.md"), HasSubstr("| 2 | 3 + 1 DDS |"));
  // Everything that it took is free again.
  EXPECT_TRUE(server_->Says("station load_2: ended")) << server_->Output();
}

TEST_F(Load, GoesOverTheNetworkAndToThePeersThatItIsGiven) {
  StartServer();
  const auto load = Start(Arguments(
      {"--network", "lo", "--peer", "127.0.0.1", "--dds-viewers", "1", "--json", In("peer.json")},
      "1"));
  ASSERT_EQ(load->Exit(60.0), 0) << load->Output();
  const Json json = Json::parse(ReadText("peer.json"));
  EXPECT_GT(json["achieved_hz"], 0.0);
  EXPECT_GT(json["dds_viewer_frames"], 0);
}

/// Whatever the machine manages, the limit follows from the runs that the program prints: a run
/// holds if less than a hundredth of it was late or lost.
void ExpectLimitOf(const std::string& what, const std::string& output) {
  const std::regex run("([0-9]+) " + what +
                       ": ([0-9.]+) % late, ([0-9.]+) % of the frames lost: (.*)");
  std::map<std::size_t, bool> held;  // by number of stations or viewers
  for (std::sregex_iterator it(output.begin(), output.end(), run); it != std::sregex_iterator();
       ++it) {
    const double late = std::stod((*it)[2]), lost = std::stod((*it)[3]);
    const bool holds = (*it)[4] == "holds";
    EXPECT_TRUE(!holds || (late <= 1.0 && lost <= 1.0)) << it->str();
    EXPECT_TRUE(holds || late >= 1.0 || lost >= 0.9) << it->str();
    held[std::stoul((*it)[1])] |= holds;
  }
  std::size_t largest = 0;
  for (const auto& [n, holds] : held) largest = holds ? n : largest;
  EXPECT_FALSE(held.empty()) << output;
  EXPECT_THAT(output, HasSubstr("limit: " + std::to_string(largest) + " " + what + " at"));
  // No number between the two was left out.
  const auto fails = held.upper_bound(largest);
  EXPECT_TRUE(fails == held.end() || fails->first == largest + 1) << output;
}

TEST_F(Load, SaysWhichNumberIsTheLargestAndWhy) {
  StartServer();
  StartGateway();
  // A busy machine may manage none; with the gateway's limit of three there are never more.
  const auto load = Start(Arguments(
      {"--find", "--stations", "1", "--viewer-url", url_, "--json", In("found.json")}, "0.5"));
  ASSERT_EQ(load->Exit(110.0), 0) << load->Output();
  EXPECT_THAT(load->Output(), testing::ContainsRegex("limit: [0-4] stations at 1 kHz"));
  EXPECT_THAT(load->Output(), testing::ContainsRegex("limit: [0-3] viewers at 30 Hz beside 1"));
  ExpectLimitOf("stations", load->Output());
  ExpectLimitOf("viewers", load->Output());
  for (const Json& run : Json::parse(ReadText("found.json"))) {
    EXPECT_LE(run["stations"], 4);
    EXPECT_LE(run["viewers"], 3);
  }
}

TEST_F(Load, KeepsTheFiguresOfTheRunsBeforeOneThatFails) {
  StartServer();
  const auto load =
      Start(Arguments({"--stations", "1", "--viewers", "0,1", "--viewer-url", "ws://127.0.0.1:1",
                       "--json", In("load.json"), "--report", In("capacity.md")},
                      "0.5"));
  EXPECT_EQ(load->Exit(60.0), 1);
  EXPECT_THAT(load->Output(), HasSubstr("no gateway answers at ws://127.0.0.1:1"));
  EXPECT_THAT(load->Output(), HasSubstr("palpate-viewer --http 1"));
  EXPECT_EQ(Json::parse(ReadText("load.json"))["viewers"], 0);
  EXPECT_THAT(ReadText("capacity.md"), HasSubstr("| 1 | 0 |"));
}

TEST_F(Load, NamesAFileThatItCannotWriteBeforeItMeasures) {
  for (const std::string option : {"--json", "--report"}) {
    const auto load = Start({option, In("nowhere/file"), "--wait", "0.1"});
    EXPECT_EQ(load->Exit(), 1);
    EXPECT_THAT(load->Output(), HasSubstr(option + " " + In("nowhere/file")));
  }
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
  const auto find = Start(Arguments({"--find", "--stations", "5"}, "0.5"));
  EXPECT_EQ(find->Exit(60.0), 1);
  EXPECT_THAT(find->Output(), HasSubstr("--stations 5: the server offers 4 tools"));
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
