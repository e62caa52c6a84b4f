// The programs on two hosts with a bad network between them: real UDP, real discovery.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "client/recorder/file_summary.h"
#include "common/dds/ports.h"
#include "common/dds/topics.h"
#include "common/realtime/steady_clock.h"
#include "devices/scripted/scripted_device.h"
#include "devices/wrench_limiter.h"
#include "tests/link/silence.h"
#include "tests/link/two_hosts.h"
#include "tests/support/test_domain.h"

namespace palpate::test {
namespace {

const std::string kDomain = std::to_string(OwnDomain());
/// What the scripted hand of tests/integration/press.json feels, 1 mm deep at 1 N/mm.
constexpr double kForce_N = 1.0;
/// The limits of the device that plays the hand.
WrenchLimits ScriptedLimits() {
  return WrenchLimits::Of(
      ScriptedDevice(ScriptPlayer(PoseScript({{0.0, Pose{}, ""}}), false)).info());
}

LinkConditions Wide() {
  LinkConditions conditions;
  conditions.delay_ns = 10'000'000;
  conditions.jitter_ns = 3'000'000;
  conditions.loss = 0.1;
  conditions.reordering = 0.05;
  conditions.duplication = 0.02;
  return conditions;
}

struct BadNetwork : testing::Test {
  const std::string file = testing::TempDir() + "palpate_network_" + std::to_string(getpid());
  std::optional<TwoHosts> hosts;
  std::unique_ptr<Program> server;

  ~BadNetwork() override {
    std::filesystem::remove(file + ".csv");
    std::filesystem::remove(file + ".json");
  }

  /// Skipped where the machine allows no such hosts; after that every failure counts.
  void SetUp() override {
    if (const std::string why_not = TwoHosts::WhyNot(); !why_not.empty()) GTEST_SKIP() << why_not;
  }
  void Connect(const LinkConditions& each_way) { hosts.emplace(each_way); }
  std::unique_ptr<Program> ServerOn(int host) const {
    return hosts->Start(
        host, PALPATE_BIN_DIR "/palpate-server",
        {"--scene", "cube", "--domain", kDomain, "--realtime", "off", "--network", TwoHosts::kLan});
  }
  bool StartServer() {
    server = ServerOn(0);
    return server->Says("ready: ", 60.0);
  }
  std::unique_ptr<Program> StartStation(const std::string& seconds,
                                        std::vector<std::string> more = {}, int host = 1) {
    std::vector<std::string> arguments{
        "--device",   "scripted",
        "--scene",    "cube",
        "--id",       "far",
        "--script",   PALPATE_SOURCE_DIR "/tests/integration/press.json",
        "--domain",   kDomain,
        "--realtime", "off",
        "--network",  TwoHosts::kLan,
        "--for",      seconds,
        "--trace",    file + ".csv",
        "--json",     file + ".json",
        "--wait",     "60",
        "--no-table"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return hosts->Start(host, PALPATE_BIN_DIR "/palpate-station", arguments);
  }
  /// A program that only watches, on the host that is not the server's.
  std::unique_ptr<Program> StartWatching(const std::string& program,
                                         std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--domain", kDomain, "--network", TwoHosts::kLan});
    return hosts->Start(1, PALPATE_BIN_DIR + program, arguments);
  }
};

TEST_F(BadNetwork, CarriesASessionWhoseStatisticsAreThoseOfTheNetwork) {
  Connect(Wide());
  ASSERT_TRUE(StartServer()) << server->Output();
  const auto station = StartStation("6");
  ASSERT_EQ(station->Exit(100.0), 0) << station->Output();
  std::ifstream in(file + ".json");
  const auto summary = nlohmann::json::parse(in);
  const std::vector<TraceRow> rows = ReadTrace(file + ".csv");
  const double sent = summary["poses"], replies = summary["replies"], lost = summary["lost"];
  double most_N = 0.0, least_ms = 1e9;
  std::size_t whole = 0;
  std::uint64_t newest = 0;
  const WrenchLimits limits = ScriptedLimits();
  for (const TraceRow& row : rows) {
    most_N = std::max(most_N, row.applied.force.norm());
    // The time from pose to reply is measured however late the tick ran; a silence of 0 means a
    // reply that came after the tick was due.
    if (row.silence_ms > 0.0) least_ms = std::min(least_ms, row.age_ms - row.silence_ms);
    whole += row.applied.force.norm() > 0.99 * kForce_N;
    EXPECT_GE(row.reply, newest);
    newest = row.reply;
  }
  std::printf(
      "%zu rows: of %.0f poses %.1f %% answered in order, %.1f %% lost, %.1f %% strays, round trip "
      "p50 %.1f ms; force at most %.3f N, whole in %.1f %% of the ticks, largest step %.3f of the "
      "slew limit\n",
      rows.size(), sent, 100.0 * replies / sent, 100.0 * lost / sent,
      100.0 * static_cast<double>(summary["strays"]) / sent,
      1e-3 * static_cast<double>(summary["rtt_us"]["p50"]), most_N,
      100.0 * static_cast<double>(whole) / static_cast<double>(rows.size()),
      LargestStep(rows, 1, rows.size(), limits));

  EXPECT_GT(replies, 1000.0);
  EXPECT_GE(least_ms, 20.0) << "nothing is faster than the network";
  EXPECT_EQ(summary["late"], summary["replies"]);
  // 0.9 x 0.9 arrive, and 0.05 of them each way are overtaken by their successor, and so too late.
  EXPECT_NEAR(lost / (lost + replies), 0.27, 0.08);
  EXPECT_EQ(summary["strays"], 0) << "DDS itself drops what is doubled, and what was overtaken";
  EXPECT_GT(most_N, 0.9 * kForce_N);
  EXPECT_LE(most_N, 1.1 * kForce_N);
  EXPECT_LE(LargestStep(rows, 1, rows.size(), limits), 1.0);
}

/// How many datagrams the kernel dropped for each of a host's UDP sockets with one of those ports
/// and no address of its own.
std::vector<long> Dropped(const TwoHosts& hosts, int host, const dds::PortRange& ports) {
  const auto table = hosts.Start(host, "/bin/cat", {"/proc/net/udp"});
  table->Exit();
  std::istringstream lines(table->Output());
  std::vector<long> dropped;
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    // "12: 00000000:1CE8 ... 0": number, own address and port in hexadecimal digits, ..., dropped.
    std::istringstream words(line);
    std::string number, address, last;
    words >> number >> address;
    while (words >> last) {
    }
    const int port = std::stoi(address.substr(address.find(':') + 1), nullptr, 16);
    if (ports.Has(port) && address.starts_with("00000000:")) dropped.push_back(std::stol(last));
  }
  return dropped;
}

TEST_F(BadNetwork, IsNotHeardByAServerThatIsForItsOwnHostAlone) {
  Connect({});
  server = hosts->Start(0, PALPATE_BIN_DIR "/palpate-server",
                        {"--scene", "cube", "--domain", kDomain, "--realtime", "off"});
  ASSERT_TRUE(server->Says("ready: ", 60.0)) << server->Output();
  const int domain = std::stoi(kDomain);
  const dds::PortRange loop = dds::PortsOf(dds::LoopDomainId(domain));
  const dds::PortRange service = dds::PortsOf(dds::ServiceDomainId(domain));
  const auto blind = hosts->Start(1, "/bin/bash",
                                  {"-c", "for ((port = " + std::to_string(loop.first) +
                                             "; port <= " + std::to_string(service.last) +
                                             "; ++port)); do echo hear me >/dev/udp/" +
                                             TwoHosts::kAddress[0] + "/$port; done 2>/dev/null"});
  blind->Exit();
  for (const dds::PortRange& ports : {loop, service}) {
    std::vector<long> dropped;
    for (int i = 0; i < 200; ++i) {
      dropped = Dropped(*hosts, 0, ports);
      if (!dropped.empty() && std::ranges::count(dropped, 0) == 0) break;
      usleep(10'000);
    }
    // Discovery and data by unicast, and discovery by multicast, over sockets that share a port
    // each.
    EXPECT_GE(dropped.size(), 3u);
    EXPECT_THAT(dropped, testing::Each(1)) << "a stranger is heard";
  }
}

TEST_F(BadNetwork, IsNoHindranceToDiscoveryWithoutMulticastWherePeersAreNamed) {
  Connect({});
  for (int host = 0; host < 2; ++host) {
    const auto off =
        hosts->Start(host, "/bin/ip", {"link", "set", TwoHosts::kLan, "multicast", "off"});
    ASSERT_EQ(off->Exit(), 0) << off->Output();
  }
  ASSERT_TRUE(StartServer()) << server->Output();
  const auto station = StartStation("1", {"--peer", TwoHosts::kAddress[0]});
  EXPECT_EQ(station->Exit(100.0), 0) << station->Output();
}

TEST_F(BadNetwork, LeavesNoForceWhenItIsCutAndThenJoinsTheTwoAgain) {
  Connect({});
  ASSERT_TRUE(StartServer()) << server->Output();
  const auto station = StartStation("8");
  ASSERT_TRUE(station->Says("session: tool")) << station->Output();
  sleep(2);
  const std::int64_t cut_ns = SteadyNanoseconds();
  hosts->wire().Cut(true);
  sleep(1);
  hosts->wire().Cut(false);
  ASSERT_EQ(station->Exit(100.0), 0) << station->Output();
  const std::vector<TraceRow> rows = ReadTrace(file + ".csv");
  const WrenchLimits limits = ScriptedLimits();
  const Silence silence = MeasureSilence(rows, cut_ns, limits);
  EXPECT_TRUE(silence.stayed_zero);
  EXPECT_LE(silence.counted_until_zero_ms, kForceGone_ms);
  EXPECT_LE(silence.largest_step, 1.0);
  EXPECT_GT(silence.until_back_ms, 150.0 * silence.share_before) << "by a ramp";
}

TEST_F(BadNetwork, IsNoHindranceToAClassThatWatchesAndRecordsOnAnotherHost) {
  Connect({});
  ASSERT_TRUE(StartServer()) << server->Output();
  const auto gateway = StartWatching("/palpate-viewer", {"--http", "8765", "--max-mice", "0"});
  ASSERT_TRUE(gateway->Says("ready: ")) << gateway->Output();
  const std::string recording = file + ".mcap";
  const auto recorder = StartWatching("/palpate-record", {"-o", recording, "--overwrite"});
  ASSERT_TRUE(recorder->Says("poses and wrenches: UDP (over lan)")) << recorder->Output();
  const auto station = StartStation("2", {}, 0);
  ASSERT_EQ(station->Exit(100.0), 0) << station->Output();
  recorder->Signal(SIGINT);
  ASSERT_EQ(recorder->Exit(), 0) << recorder->Output();

  std::map<RecordedType, std::uint64_t> messages;
  const FileSummary summary = Summarise({recording});
  std::filesystem::remove(recording);
  for (const auto& [name, topic] : summary.topics) {
    const std::optional<RecordedType> type = TypeOfSchema(topic.type);
    ASSERT_TRUE(type) << topic.type;
    messages[*type] += topic.messages;
  }
  // There are 120 tool states and 2000 poses in two seconds; a busy machine may lose many.
  EXPECT_GT(messages[RecordedType::kToolState], 30u);
  EXPECT_GT(messages[RecordedType::kHapticPose], 500u);
  EXPECT_GT(messages[RecordedType::kWrench], 500u);
  EXPECT_GT(messages[RecordedType::kStationStatistics], 0u);
  EXPECT_EQ(messages[RecordedType::kSceneBundle], 1u);

  // The gateway has the scene as well, and gives it to clients there.
  std::string health;
  for (int i = 0; i < 100 && health.find("\"cube\"") == std::string::npos; ++i) {
    const auto client =
        hosts->Start(1, "/bin/bash",
                     {"-c",
                      "exec 3<>/dev/tcp/127.0.0.1/8765; printf 'GET /healthz HTTP/1.1\\r\\nHost: "
                      "127.0.0.1:8765\\r\\nConnection: close\\r\\n\\r\\n' >&3; cat <&3"});
    ASSERT_EQ(client->Exit(), 0) << client->Output();
    health = client->Output();
  }
  EXPECT_THAT(health, testing::HasSubstr("\"cube\""));
}

TEST(Network, IsNotForSharedMemory) {
  Program station(PALPATE_BIN_DIR "/palpate-station",
                  {"--device", "scripted", "--scene", "cube", "--id", "far", "--transport", "shm",
                   "--network", "eth0"});
  EXPECT_EQ(station.Exit(), 1);
  EXPECT_THAT(station.Output(), testing::HasSubstr("omit --network 'eth0'"));
}

}  // namespace
}  // namespace palpate::test
