#include "client/station/session_link.h"

#include <atomic>
#include <vector>

#include <gmock/gmock.h>

#include "client/station/served_tools.h"
#include "common/dds/topics.h"
#include "common/realtime/steady_clock.h"
#include "tests/station/fake_server.h"
#include "tests/station/still_device.h"
#include "tests/support/complaint.h"
#include "tests/support/eventually.h"
#include "tests/support/test_domain.h"

namespace palpate {
namespace {

using test::FakeServer;

const int kDomain = test::OwnDomain();
const std::string kNumber = std::to_string(kDomain);
const dds::TransportChoice kUdp{dds::Transport::kUdp, "UDP (as asked)"};

/// A whole station except for main: its device is pressed 2 mm into the fake server's floor.
struct Station {
  test::StillDevice device;
  std::unique_ptr<StationCore> core;
  ReplyRing replies;
  std::unique_ptr<ServoThread> servo;
  std::vector<std::string> said;
  std::unique_ptr<SessionLink> link;
  StationSnapshot snapshot;

  explicit Station(double patience_s = 10.0, bool awaits_recorder = false) {
    device.sample.X_WH.p = Vec3(0, 0, -0.002);
    core = std::make_unique<StationCore>(device);
    core->EnableForces(true);
    LinkOptions options;
    options.station = "hand";
    options.scene = "floor";
    options.domain = kDomain;
    options.transport = dds::Transport::kUdp;
    options.realtime.mode = RealtimeMode::kOff;
    options.patience_s = patience_s;
    options.awaits_recorder = awaits_recorder;
    link = std::make_unique<SessionLink>(
        options, replies,
        [this]() -> ServoThread& {
          servo = std::make_unique<ServoThread>(*core, replies, 0.01);
          return *servo;
        },
        [this](const std::string& event) { said.push_back(event); });
  }
  ~Station() {
    link.reset();
    servo->Stop();
  }

  bool Until(const std::function<bool()>& so, double seconds = 20.0) {
    return test::Eventually(
        [&] {
          link->Poll(SteadyNanoseconds());
          while (servo->ReadSnapshot(snapshot)) {
          }
          return so();
        },
        seconds);
  }
  bool UntilForce(double newton) {
    return Until([=, this] { return std::abs(snapshot.force_N - newton) < 1e-9; });
  }
  std::string Complaint() {
    return test::ComplaintOf([this] { Until([] { return false; }); });
  }
};

/// A station that feels the floor.
struct LinkedStation : testing::Test {
  void SetUp() override { ASSERT_TRUE(station.UntilForce(2.0)); }
  FakeServer server{kDomain, kUdp};
  Station station;
};

TEST(SessionLink, LosesNoPoseAtTheStart) {
  FakeServer server(kDomain, kUdp);
  Station station;
  ASSERT_TRUE(station.Until([&] { return server.poses > 100; }));
  EXPECT_EQ(server.last_sequence.load(), server.poses + server.gaps);
}

// The answer to the first pose must be recorded, too: a replay of poses alone does not know which
// of them the server's loop took.
TEST(SessionLink, SendsNoPoseBeforeARecorderReadsItAndTheServerKnowsWhoReadsItsAnswers) {
  FakeServer server(kDomain, kUdp);
  Station station(10.0, true);
  EXPECT_FALSE(station.Until([&] { return server.poses > 0; }, 1.0));
  const dds::Participant participant = dds::Participant::Loop(kDomain, kUdp);
  std::atomic<std::uint64_t> first = 0;
  const dds::Reader<wire::HapticPose> recorder(
      participant, dds::PoseTopic("hand", station.link->run()), dds::Qos::kRecord,
      [&](const wire::HapticPose& pose) {
        std::uint64_t none = 0;
        first.compare_exchange_strong(none, pose.pose_sequence);
      });
  EXPECT_FALSE(station.Until([&] { return server.poses > 0; }, 3.5)) << "nobody records answers";
  EXPECT_THAT(station.said, testing::Contains("no recorder was found within 3 s: waiting for it"));
  const dds::Reader<wire::Wrench> of_answers(participant,
                                             dds::WrenchTopic("hand", station.link->run()),
                                             dds::Qos::kRecord, [](const wire::Wrench&) {});
  ASSERT_TRUE(station.UntilForce(2.0));
  EXPECT_EQ(first, 1u);
}

TEST(SessionLink, SaysWhyTheServerRefuses) {
  FakeServer server(kDomain, kUdp);
  server.Refuse("scene 'floor' is not served here; choose one of: cube");
  Station station;
  EXPECT_EQ(
      station.Complaint(),
      "the server refuses the session: scene 'floor' is not served here; choose one of: cube");
}

TEST(SessionLink, SaysWhenNoServerAnswers) {
  Station station(0.2);
  const std::string complaint = station.Complaint();
  EXPECT_THAT(complaint, testing::HasSubstr("no server answers in domain " + kNumber));
  EXPECT_THAT(complaint, testing::HasSubstr("palpate-server --scene floor"));
  EXPECT_THAT(complaint, testing::HasSubstr("where it has an --identity, give one"));
}

TEST(SessionLink, WaitsForAServerThatStartsLater) {
  Station station;
  EXPECT_FALSE(
      station.Until([&] { return station.link->phase() != SessionLink::Phase::kAsking; }, 0.3));
  FakeServer server(kDomain, kUdp);
  EXPECT_TRUE(station.UntilForce(2.0));
}

TEST(SessionLink, FadesWhenTheServerDiesAndResumesByItselfWithItsSuccessor) {
  auto server = std::make_unique<FakeServer>(kDomain, kUdp);
  Station station;
  ASSERT_TRUE(station.UntilForce(2.0));
  server.reset();
  ASSERT_TRUE(station.UntilForce(0.0));
  server = std::make_unique<FakeServer>(kDomain, kUdp);
  ASSERT_TRUE(station.UntilForce(2.0));
  EXPECT_EQ(station.link->reconnects(), 1);
}

TEST_F(LinkedStation, LeavesTheHandWithoutAForceWhereTwoServersAnswer) {
  FakeServer other(kDomain, kUdp);
  EXPECT_EQ(station.Complaint(),
            "two servers run in domain " + kNumber +
                ": end one of them, or give it and its stations another --domain");
  station.link.reset();
  station.servo->Stop();
  EXPECT_FALSE(station.core->renders_force());
}

TEST_F(LinkedStation, IsNeitherEndedNorMutedByAStrangersWordInItsServersName) {
  const dds::Participant participant = dds::Participant::Service(kDomain);
  dds::Reader<wire::SessionState> states(participant, dds::kSessionStateTopic,
                                         dds::Qos::kRecordSession);
  dds::Writer<wire::SessionState> stranger(participant, dds::kSessionStateTopic,
                                           dds::Qos::kSession);
  wire::SessionState state{};
  ASSERT_TRUE(
      station.Until([&] { return states.Take(state) && state.run == station.link->run(); }));
  ASSERT_TRUE(station.Until([&] { return stranger.matched_readers() >= 2; }));
  state.muted = true;
  for (const wire::SessionPhase phase :
       {palpate_SESSION_ACTIVE, palpate_SESSION_REFUSED, palpate_SESSION_ENDED}) {
    state.phase = phase;
    stranger.Write(state);
  }
  state.server_run += 1;
  stranger.Write(state);
  ASSERT_TRUE(station.Until([&] { return !station.said.empty() && station.said.size() > 1; }));
  station.Until([] { return false; }, 0.5);
  EXPECT_EQ(station.link->PhaseText(), "active");
  EXPECT_EQ(station.link->reconnects(), 0);
  EXPECT_EQ(station.snapshot.force_N, 2.0);
}

TEST(SessionLink, SaysWhatASuccessorRefusesAndThatItAsksOn) {
  auto server = std::make_unique<FakeServer>(kDomain, kUdp);
  Station station;
  ASSERT_TRUE(station.UntilForce(2.0));
  server.reset();
  server = std::make_unique<FakeServer>(kDomain, kUdp);
  server->Refuse("tool 'sphere' of scene 'floor' is driven by station 'other'");
  ASSERT_TRUE(station.Until([&] {
    return !station.said.empty() &&
           station.said.back() ==
               "the server refuses the session: tool 'sphere' of scene 'floor' is driven by "
               "station 'other'; asking again for 10 s";
  }));
  const std::size_t said = station.said.size();
  station.Until([] { return false; }, 2.5);
  EXPECT_EQ(station.said.size(), said) << "once";
}

TEST_F(LinkedStation, AsksAgainWhenTheServerEndsTheSessionThoughItsLastWordWasLost) {
  for (const bool says_so : {true, false}) {
    (says_so ? server.ends_session : server.forgets_session) = true;
    const int sessions = says_so ? 2 : 3;
    ASSERT_TRUE(station.Until([&] { return station.link->reconnects() == sessions - 1; }));
    ASSERT_TRUE(station.UntilForce(2.0));
    EXPECT_EQ(server.sessions.load(), sessions);
    EXPECT_THAT(station.said,
                testing::Contains("the server ended the session (no pose came for more than 100 "
                                  "ms): asking again"));
  }
}

TEST_F(LinkedStation, TakesTheForceOutWhileItIsMutedAndFollowsTheHand) {
  server.mutes_station = true;
  ASSERT_TRUE(station.UntilForce(0.0));
  EXPECT_EQ(station.link->PhaseText(), "muted");
  EXPECT_THAT(station.said.back(), testing::HasSubstr("muted: forces are off"));
  const std::uint64_t poses = server.poses;
  ASSERT_TRUE(station.Until([&] { return server.poses > poses + 100; }));
  EXPECT_EQ(station.snapshot.force_N, 0.0);
  server.ends_session = true;  // which does not unmute
  ASSERT_TRUE(station.Until([&] { return station.link->reconnects() == 1; }));
  station.Until([] { return false; }, 0.5);
  EXPECT_EQ(station.snapshot.peak_force_N, 0.0);
  server.mutes_station = false;
  EXPECT_TRUE(station.UntilForce(2.0));
  EXPECT_EQ(station.link->PhaseText(), "active");
}

TEST(SessionLink, WaitsAsLongAsItIsHeld) {
  FakeServer server(kDomain, kUdp);
  server.holds = true;
  Station station(0.5);
  ASSERT_TRUE(station.Until([&] { return station.link->PhaseText() == "held"; }));
  EXPECT_FALSE(station.Until([&] { return station.link->PhaseText() != "held"; }, 1.0))
      << "its patience is for a server that does not answer";
  EXPECT_EQ(station.said.back(), "the session is held: waits to be admitted");
  server.holds = false;
  EXPECT_TRUE(station.UntilForce(2.0));
}

TEST_F(LinkedStation, RebuildsItsReaderAndThenItsSessionWhenMatchedButDeaf) {
  server.mute = true;
  ASSERT_TRUE(station.Until([&] { return station.said.size() > 1; }));
  EXPECT_EQ(station.said.back(), "no replies for 1 s: forces are zero until they come again");
  server.mute = false;
  ASSERT_TRUE(station.UntilForce(2.0));
  EXPECT_EQ(station.said.back(), "replies come again: forces ramp in");
  server.mute = true;
  ASSERT_TRUE(station.Until([&] { return server.sessions > 1; }));
  EXPECT_EQ(station.snapshot.force_N, 0.0);
  EXPECT_FALSE(server.left) << "it was cut off, and has not left";
  server.mute = false;
  EXPECT_TRUE(station.UntilForce(2.0));
}

TEST(SessionLink, LeavesARunThatNobodyAnsweredBeforeItAsksAnew) {
  FakeServer server(kDomain, kUdp);
  server.mute = true;
  Station station;
  ASSERT_TRUE(station.Until([&] { return server.sessions > 1; }, 40.0));
  EXPECT_TRUE(server.left) << "its name would be held against it";
  server.mute = false;
  EXPECT_TRUE(station.UntilForce(2.0));
}

TEST(SessionLink, TakesNoReplyThatDoesNotEchoThePoseAsItWasSent) {
  FakeServer server(kDomain, kUdp);
  server.lies = true;
  Station station;
  ASSERT_TRUE(station.Until([&] { return server.poses > 500; }));
  EXPECT_EQ(station.servo->newest_reply_ns(), 0);
  EXPECT_EQ(station.snapshot.force_N, 0.0);
  server.lies = false;
  EXPECT_TRUE(station.UntilForce(2.0));
}

TEST_F(LinkedStation, ReleasesTheSessionAtItsEnd) {
  station.link.reset();
  EXPECT_TRUE(server.left);
}

}  // namespace
}  // namespace palpate
