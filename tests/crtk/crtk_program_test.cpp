// palpate-crtk between a real server with a station, and another vendor's DDS in another process.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <functional>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/integration/rig.h"
#include "tests/support/stall_witness.h"

namespace palpate::test {
namespace {

using nlohmann::json;

/// The Fast DDS program, with pipes as its standard input and output.
class Peer {
 public:
  Peer(int domain, const std::string& ros_namespace) {
    int down[2], up[2];
    if (pipe(down) != 0 || pipe(up) != 0) return;
    pid_ = fork();
    if (pid_ == 0) {
      dup2(down[0], STDIN_FILENO);
      dup2(up[1], STDOUT_FILENO);
      for (const int fd : {down[0], down[1], up[0], up[1]}) close(fd);
      execl(PALPATE_BIN_DIR "/palpate_fastdds_peer", "palpate_fastdds_peer",
            std::to_string(domain).c_str(), ros_namespace.c_str(), nullptr);
      _exit(127);
    }
    close(down[0]);
    close(up[1]);
    to_ = fdopen(down[1], "w");
    from_ = fdopen(up[0], "r");
    EXPECT_EQ(Line(), "peer: ready\n");
  }
  ~Peer() {
    fclose(to_);  // which ends it
    fclose(from_);
    waitpid(pid_, nullptr, 0);
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  pid_t id() const { return pid_; }
  void Tell(const std::string& line) {
    std::fputs((line + "\n").c_str(), to_);
    std::fflush(to_);
  }
  json Report() {
    Tell("report");
    return json::parse(Line(), nullptr, false);
  }

 private:
  std::string Line() {
    std::string line;
    for (int c = 0; (c = std::fgetc(from_)) != EOF;) {
      line += static_cast<char>(c);
      if (c == '\n') break;
    }
    return line;
  }
  pid_t pid_ = -1;
  FILE *to_ = nullptr, *from_ = nullptr;
};

class BridgeProgram : public Program {
 public:
  BridgeProgram()
      : Program(PALPATE_BIN_DIR "/palpate-crtk",
                {"--domain", std::to_string(kDomain), "--transport", "udp", "--ros-domain",
                 std::to_string(kDomain), "--guide-force", "1"}) {}
};

class CrtkProgram : public testing::Test {
 protected:
  /// Reads the peer's reports until the condition holds.
  bool Becomes(Peer& peer, const std::function<bool(const json&)>& wanted) {
    return Eventually(
        [&] {
          last = peer.Report();
          if (!last.is_object()) return false;
          if (wanted(last)) return true;
          usleep(50'000);
          return false;
        },
        60.0);
  }
  json last;
};

TEST_F(CrtkProgram, GivesEverySampleToAnotherVendorsDdsAsRos2NamesIt) {
  constexpr const char* kTopics[] = {"measured_cp", "measured_cv", "measured_cf"};
  ServerProgram server("udp");
  ASSERT_TRUE(server.Ready());
  // Spoilt where samples were lost.
  ASSERT_TRUE(Shown([&](StallWitness& witness) {
    Peer peer(kDomain, "/hand");
    BridgeProgram bridge;
    EXPECT_TRUE(bridge.Says("ready:"));
    StationProgram station("hand", "udp", {"--loop"});
    for (const pid_t id : {server.id(), peer.id(), bridge.id(), station.id()}) witness.Watch(id);
    if (!Becomes(peer, [](const json& r) { return r["measured_cf"]["count"] > 2000; })) {
      ADD_FAILURE() << last.dump().substr(0, 2000) << bridge.Output() << station.Output();
      return Attempt::kFailed;
    }
    const bool lost =
        std::ranges::any_of(kTopics, [&](const char* topic) { return last[topic]["lost"] != 0; });
    return lost ? Attempt::kSpoilt : Attempt::kShown;
  }));
  if (IsSkipped()) return;

  for (const char* topic : kTopics) EXPECT_EQ(last[topic]["frame"], "cube") << topic;
  // The hand is 1 mm deep in the cube's top face, 1 N/mm.
  EXPECT_NEAR(last["measured_cp"]["numbers"][1].get<double>(), 0.030, 0.004);
  EXPECT_NEAR(last["measured_cp"]["numbers"][6].get<double>(), 1.0, 1e-6);  // w comes last
  EXPECT_EQ(last["operating_state"]["state"], "ENABLED");
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  EXPECT_NEAR(last["measured_cp"]["stamp"].get<double>(), static_cast<double>(now.tv_sec), 10.0);

  const json& writers = last["writers"];
  EXPECT_EQ(writers["rt/hand/measured_cp"][0], "geometry_msgs::msg::dds_::PoseStamped_");
  EXPECT_EQ(writers["rt/hand/measured_cp"][1],
            "typehash=RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8;");
  EXPECT_EQ(writers["rt/hand/operating_state"][0], "crtk_msgs::msg::dds_::OperatingState_");
}

TEST_F(CrtkProgram, LeavesOutAStationWhoseNameRosCannotHaveAndSaysWhatToDo) {
  ServerProgram server("udp");
  ASSERT_TRUE(server.Ready());
  BridgeProgram bridge;
  ASSERT_TRUE(bridge.Says("ready:"));
  StationProgram station("left__hand", "udp", {"--loop"});
  EXPECT_TRUE(bridge.Says(
      "left__hand' is left out: names of ROS 2 have no '__'; give the station an --id without it"))
      << bridge.Output();
  bridge.Signal(SIGTERM);
  EXPECT_EQ(bridge.Exit(), 0);
  EXPECT_EQ(bridge.Output().find("measured_cp"), std::string::npos) << bridge.Output();
}

TEST_F(CrtkProgram, TakesCommandsAndPullsTheHandOnlyWhileItIsAskedTo) {
  ServerProgram server("udp");
  ASSERT_TRUE(server.Ready());
  Peer peer(kDomain, "/hand");
  BridgeProgram bridge;
  ASSERT_TRUE(bridge.Says("ready:"));
  StationProgram station("hand", "udp", {"--loop", "--accept-guide", "--guide-force", "1"});
  ASSERT_TRUE(
      Becomes(peer, [](const json& r) { return r["operating_state"]["state"] == "ENABLED"; }));

  // The station hears what any listener in its domain hears.
  const dds::Participant service = dds::Participant::Service(kDomain, {});
  GuideLink link(service, "hand");
  std::optional<GuideAim> aim;
  std::int64_t aim_ns = 0;
  const auto hear = [&] {
    link.Poll([&](const GuideAim& heard) {
      aim = heard;
      aim_ns = SteadyNanoseconds();
    });
  };
  peer.Tell("force 0.2 0 0 another_frame");
  ASSERT_TRUE(bridge.Says("because its frame is"));
  hear();
  EXPECT_FALSE(aim) << "a force in a frame that nobody knows";
  peer.Tell("force 1 0 0");
  ASSERT_TRUE(Eventually([&] {
    hear();
    return aim.has_value();
  }));
  peer.Tell("quiet");
  // The station lets go once the guide counts as silent; the bridge adds no aim of its own.
  EXPECT_TRUE(Eventually([&] {
    hear();
    return SteadyNanoseconds() - aim_ns > Guide::kSilent_ns;
  }));

  // The bridge logs one such word a second.
  EXPECT_TRUE(Eventually([&] {
    peer.Tell("command dance");
    return bridge.Says("not done", 0.5);
  }));
  peer.Tell("command pause");
  EXPECT_TRUE(
      Becomes(peer, [](const json& r) { return r["operating_state"]["state"] == "PAUSED"; }));
  peer.Tell("command resume");
  EXPECT_TRUE(
      Becomes(peer, [](const json& r) { return r["operating_state"]["state"] == "ENABLED"; }));
  bridge.Signal(SIGINT);
  EXPECT_EQ(bridge.Exit(), 0);
}

}  // namespace
}  // namespace palpate::test
