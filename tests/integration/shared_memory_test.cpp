// The programs over shared memory, and what its transport gets wrong by itself: it forgets chunks
// and knows no domains (common/dds/endpoint.h, common/dds/participant.cpp).
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/common/dds/peer.h"
#include "tests/common/dds/roudi.h"
#include "tests/integration/rig.h"

namespace palpate::test {
namespace {

using std::chrono::milliseconds;

constexpr int kForeignDomain = 35;

/// The least that is a station, so that many of them take little time.
class QuickStation {
 public:
  explicit QuickStation(std::string name) : name_(std::move(name)) {}

  /// One session: asks, meets the server, and sends until `answers` came.  False where that takes
  /// more than 20 s.
  bool Begin(std::uint64_t run) {
    run_ = run;
    answered_ = 0;
    Ask(false);
    if (!Eventually([&] { return Phase() == palpate_SESSION_WAITING; })) return false;
    poses_ = {loop_, dds::PoseTopic(name_, run), dds::Qos::kLoop};
    const std::string topic = dds::WrenchTopic(name_, run);
    if (!Eventually([&] { return dds::WriterDiscovered(loop_, topic); })) return false;
    wrenches_ = {loop_, topic, dds::Qos::kLoop, [this](const wire::Wrench&) { ++answered_; }};
    return Eventually([&] { return poses_.matched_readers() == 1; });
  }
  bool Answered(int answers) {
    const int end = answered_ + answers;
    return Eventually([&] {
      Send();
      return answered_ >= end;
    });
  }
  bool Leave() {
    Ask(true);
    const bool left = Eventually([&] { return Phase() == palpate_SESSION_ENDED; });
    poses_ = {};
    wrenches_ = {};
    return left;
  }
  bool uses_shared_memory() const {
    return poses_.uses_shared_memory() && wrenches_.uses_shared_memory();
  }

 private:
  void Ask(bool leave) {
    wire::SessionRequest request{};
    wire::FromText(name_, request.station);
    request.run = run_;
    wire::FromText("cube", request.scene);
    request.leave = leave;
    requests_.Write(request);
  }
  wire::SessionPhase Phase() {
    wire::SessionState state;
    while (states_.Take(state)) {
      if (state.run == run_) state_ = state;
    }
    return state_.run == run_ ? state_.phase : palpate_SESSION_REFUSED;
  }
  void Send() {
    wire::HapticPose pose{};
    pose.pose_sequence = ++sequence_;
    pose.sample_time_ns = SteadyNanoseconds();
    pose.position_m[1] = 0.030 - kDepth_m;
    pose.orientation_wxyz[0] = 1.0;
    poses_.Write(pose);
  }

  std::string name_;
  std::uint64_t run_ = 0, sequence_ = 0;
  std::atomic<int> answered_{0};
  wire::SessionState state_{};
  dds::Participant loop_ =
      dds::Participant::Loop(kDomain, {dds::Transport::kSharedMemory, "as asked"});
  dds::Participant service_ = dds::Participant::Service(kDomain);
  dds::Writer<wire::SessionRequest> requests_{service_, dds::kSessionRequestTopic,
                                              dds::Qos::kSession};
  dds::Reader<wire::SessionState> states_{service_, dds::kSessionStateTopic, dds::Qos::kSession};
  dds::Writer<wire::HapticPose> poses_;
  dds::Reader<wire::Wrench> wrenches_;
};

TEST(SharedMemory, CarriesTheForceFromTheServerToTheStation) {
  RouDi roudi;
  ServerProgram server("auto");
  ASSERT_TRUE(server.Ready()) << server.Output();
  EXPECT_THAT(server.Output(), testing::HasSubstr("transport shared memory (RouDi answers)"));
  const std::string file = testing::TempDir() + "/palpate_" + std::to_string(getpid()) + ".json";
  StationProgram station("hand", "shm", {"--for", "1.5", "--json", file});
  ASSERT_EQ(station.Exit(), 0) << station.Output();
  std::ifstream in(file);
  const auto summary = nlohmann::json::parse(in);
  std::filesystem::remove(file);
  EXPECT_EQ(summary["transport"], "shared memory");
  EXPECT_NEAR(summary["force_N_max"], kForce_N, 0.2 * kForce_N);
  EXPECT_GT(summary["replies"], 300);
  server.Signal(SIGTERM);
  EXPECT_EQ(server.Exit(), 0) << server.Output();
}

TEST(SharedMemory, HearsTheHundredAndFirstRunOfAStation) {
  RouDi roudi;
  ServerProgram server("shm");
  ASSERT_TRUE(server.Ready()) << server.Output();
  QuickStation station("again");
  for (std::uint64_t run = 1; run <= 100; ++run) {
    ASSERT_TRUE(station.Begin(run)) << "run " << run << "\n" << server.Output();
    ASSERT_TRUE(station.Answered(3)) << "run " << run << "\n" << server.Output();
    ASSERT_TRUE(station.Leave()) << "run " << run << "\n" << server.Output();
  }
  ASSERT_TRUE(station.Begin(101));
  EXPECT_TRUE(station.Answered(300)) << "more than the 257 chunks that a reader can lose";
  EXPECT_TRUE(station.uses_shared_memory());
}

TEST(SharedMemory, KeepsASessionFromAnotherDomainsWriterOfTheSameTopic) {
  RouDi roudi;
  ServerProgram server("shm");
  ASSERT_TRUE(server.Ready()) << server.Output();
  QuickStation station("mine");
  ASSERT_TRUE(station.Begin(7));
  ASSERT_TRUE(station.Answered(1));
  Peer foreign("shm", kForeignDomain, dds::PoseTopic("mine", 7), 600, "at-once");
  while (foreign.running()) ASSERT_TRUE(station.Answered(1));
  EXPECT_TRUE(station.Answered(300));
  EXPECT_TRUE(station.Leave());
  // Its poses carry impossible ones: had they come, they would have been counted.
  EXPECT_THAT(server.Output(), testing::Not(testing::ContainsRegex("rejected +[1-9]")));
}

}  // namespace
}  // namespace palpate::test
