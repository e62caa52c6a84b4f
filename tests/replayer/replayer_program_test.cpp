// The replayer as a program: replaying to viewers, and guiding a station's hand.
#include "tests/replayer/replayer_program.h"

#include <csignal>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "common/dds/cdr_reader.h"
#include "common/dds/server_lock.h"
#include "tests/common/recording/samples.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

constexpr std::int64_t kFrame_ns = 16'000'000;

/// Two seconds for viewers: a scene, a session, a block each half second, 60 tool states a second.
void RecordForViewers(const std::string& file) {
  RecordingWriter writer({.file = file});
  AddBundle(writer, std::vector<std::uint8_t>(300'000, 9), 0);
  Add(writer, dds::kSessionStateTopic, SampleState("hand", 5), 0);
  for (std::uint64_t i = 0; i < 125; ++i) {
    const std::int64_t now_ns = static_cast<std::int64_t>(i) * kFrame_ns;
    if (i % 30 == 10) Add(writer, dds::kSolidBlockTopic, SampleBlock(1 + i / 30), now_ns);
    wire::ToolState tool{};
    wire::FromText("hand", tool.station);
    tool.pose_sequence = i;
    Add(writer, dds::kToolStateTopic, tool, now_ns);
    Add(writer, dds::PoseTopic("hand", 5), SamplePose(i), now_ns);
  }
  writer.Close("");
}

class Viewer {
 public:
  bool SeesFrame(std::uint64_t last) {
    return Sees([&] { return !frames.empty() && frames.back() == last; });
  }
  void Poll() {
    wire::ToolState tool{};
    while (tools_.Take(tool)) frames.push_back(tool.pose_sequence);
    wire::SessionState state{};
    while (states_.Take(state)) {
      ++states;
      last_phase = state.phase;
    }
    dds::CdrSample raw;
    wire::SolidBlock block{};
    while (blocks_.Take(raw, block)) changes.push_back(block.change);
    dds::FreeContents(block);
    wire::SceneBundle bundle{};
    while (bundles_.Take(raw, bundle)) {
      EXPECT_EQ(bundle.bundle._length, 300'000u);
      runs.push_back(bundle.server_run);
    }
    dds::FreeContents(bundle);
  }

  template <class Condition>
  bool Sees(Condition condition) {
    return Eventually([&] {
      Poll();
      return condition();
    });
  }

  std::vector<std::uint64_t> frames, changes, runs;
  int states = 0;
  palpate_SessionPhase last_phase{};

 private:
  dds::Participant service_ = dds::Participant::Service(kDomain);
  dds::Reader<wire::ToolState> tools_{service_, dds::kToolStateTopic, dds::Qos::kRecord};
  dds::Reader<wire::SessionState> states_{service_, dds::kSessionStateTopic,
                                          dds::Qos::kRecordSession};
  dds::CdrReader<wire::SolidBlock> blocks_{service_, dds::kSolidBlockTopic,
                                           dds::Qos::kRecordSession};
  dds::CdrReader<wire::SceneBundle> bundles_{service_, dds::kSceneBundleTopic,
                                             dds::Qos::kRecordSession};
};

class ReplayerProgramTest : public testing::Test {
 protected:
  ReplayerProgramTest() { RecordForViewers(file_); }

  Folder folder_;
  std::string file_ = folder_ / "a.mcap";
};

TEST_F(ReplayerProgramTest, ShowsViewersARecordingAsIfLive) {
  Viewer viewer;
  ReplayerProgram replayer({file_, "--domain", kDomainText});
  EXPECT_TRUE(viewer.SeesFrame(124)) << replayer.Output();
  EXPECT_EQ(replayer.Exit(), 0) << replayer.Output();
  EXPECT_GT(viewer.frames.size(), 60u);
  EXPECT_TRUE(std::ranges::is_sorted(viewer.frames));
  EXPECT_TRUE(viewer.Sees([&] { return viewer.states == 2; })) << "the session begins and ends";
  EXPECT_EQ(viewer.last_phase, palpate_SESSION_ENDED);
  EXPECT_THAT(viewer.changes, testing::ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(viewer.runs, testing::SizeIs(1));
  // Viewers would ignore a run that they know to be over, so the next replay has another one.
  ReplayerProgram again({file_, "--domain", kDomainText, "--rate", "20"});
  EXPECT_TRUE(viewer.Sees([&] { return viewer.runs.size() == 2; })) << again.Output();
  EXPECT_EQ(again.Exit(), 0) << again.Output();
}

TEST_F(ReplayerProgramTest, BeginsAndEndsWhereItIsToldWithAllThatHoldsThen) {
  Viewer viewer;
  ReplayerProgram replayer(
      {file_, "--domain", kDomainText, "--from", "0.8", "--to", "1.2", "--rate", "2"});
  EXPECT_EQ(replayer.Exit(), 0) << replayer.Output();
  ASSERT_TRUE(viewer.SeesFrame(75));
  EXPECT_GE(viewer.frames.front(), 50u);
  EXPECT_THAT(viewer.changes, testing::ElementsAre(1, 2, 3));
  EXPECT_GE(viewer.states, 1);
}

TEST_F(ReplayerProgramTest, LetsEachRoundFindTheSceneWhole) {
  Viewer viewer;
  ReplayerProgram replayer({file_, "--domain", kDomainText, "--rate", "20", "--loop"});
  EXPECT_TRUE(viewer.Sees([&] { return viewer.runs.size() >= 3; })) << replayer.Output();
  replayer.Signal(SIGINT);
  EXPECT_EQ(replayer.Exit(), 0) << replayer.Output();
  EXPECT_EQ(std::set<std::uint64_t>(viewer.runs.begin(), viewer.runs.end()).size(),
            viewer.runs.size());
}

TEST_F(ReplayerProgramTest, IsSilentWhereAServerSpeaks) {
  const ServerLock server(kDomain);
  ReplayerProgram replayer({file_, "--domain", kDomainText});
  EXPECT_EQ(replayer.Exit(), 1);
  EXPECT_THAT(replayer.Output(), HasSubstr("another --domain"));
}

TEST_F(ReplayerProgramTest, SaysThatItCannotVerifyAndWhy) {
  ReplayerProgram replayer({file_, "--verify"});
  EXPECT_EQ(replayer.Exit(), 1);
  EXPECT_THAT(replayer.Output(), HasSubstr("scene 'cube': is not a Palpate scene bundle"));
}

TEST_F(ReplayerProgramTest, VerifiesAGoldenRecordingAndSaysHowFast) {
  ReplayerProgram replayer(
      {PALPATE_SOURCE_DIR "/tests/replayer/golden/cube.mcap", "--verify", "--json", "-"});
  EXPECT_EQ(replayer.Exit(), 0) << replayer.Output();
  const auto json = nlohmann::json::parse(replayer.Output());
  EXPECT_TRUE(json["good"]);
  EXPECT_EQ(json["sessions"][0]["verified"], 400);
}

/// 20 s of an expert's hand that stands still, `beside_m` beside the held one.
void WriteStillHand(const std::string& file, double beside_m) {
  RecordingWriter writer({.file = file});
  for (std::uint64_t i = 1; i <= 20'000; ++i) {
    wire::HapticPose pose{};
    pose.pose_sequence = i;
    pose.sample_time_ns = static_cast<std::int64_t>(i) * 1'000'000;
    pose.position_m[0] = beside_m;
    pose.position_m[1] = 0.030 - kDepth_m;
    pose.orientation_wxyz[0] = 1.0;
    Add(writer, dds::PoseTopic("expert", 1), pose, pose.sample_time_ns);
  }
  Add(writer, dds::kSessionStateTopic, SampleState("expert", 1), 0);
  writer.Close("");
}

TEST(GuidedStation, IsPulledWithinItsLimitAndNoLongerOnceTheGuideIsGone) {
  const Folder folder;
  const std::string file = folder / "expert.mcap";
  WriteStillHand(file, 0.004);
  ServerProgram server("udp");
  ASSERT_TRUE(server.Ready()) << server.Output();
  StationProgram refusing("refusing", "udp", {"--for", "1"});
  ReplayerProgram nobody({file, "--guide", "refusing", "--to", "0.5", "--domain", kDomainText});
  EXPECT_EQ(nobody.Exit(), 1);
  EXPECT_THAT(nobody.Output(), HasSubstr("--accept-guide"));
  EXPECT_EQ(refusing.Exit(), 0) << refusing.Output();

  HeldStation station;
  station.AcceptGuide(0.5);
  ASSERT_TRUE(station.UntilForce());
  ReplayerProgram guide({file, "--guide", "held", "--domain", kDomainText});
  // 0.4 N sideways from the guide's spring, beside 1 N from the cube.
  const double led_N = std::hypot(kForce_N, 0.4);
  EXPECT_TRUE(station.Until([&] { return std::abs(station.device.force_N - led_N) < 0.01; }))
      << station.device.force_N << guide.Output();
  guide.Signal(SIGKILL);
  EXPECT_EQ(guide.Exit(), -SIGKILL);
  EXPECT_TRUE(station.Until([&] { return std::abs(station.device.force_N - kForce_N) < 0.01; }))
      << station.device.force_N;
}

TEST(GuidedStation, IsWaitedForWhereItsHandStaysBehind) {
  const Folder folder;
  const std::string file = folder / "expert.mcap";
  WriteStillHand(file, 0.030);
  ServerProgram server("udp");
  ASSERT_TRUE(server.Ready()) << server.Output();
  HeldStation station;
  station.AcceptGuide(0.5);
  ASSERT_TRUE(station.UntilForce());
  ReplayerProgram guide({file, "--guide", "held", "--to", "1", "--domain", kDomainText});
  EXPECT_TRUE(guide.Says("waiting for the hand, 30 mm behind")) << guide.Output();
  station.For(2.0);
  EXPECT_TRUE(guide.Runs()) << guide.Output();
  guide.Signal(SIGINT);
  EXPECT_EQ(guide.Exit(), 0) << guide.Output();

  ReplayerProgram hasty(
      {file, "--guide", "held", "--no-wait", "--to", "1", "--domain", kDomainText});
  EXPECT_EQ(hasty.Exit(), 0) << hasty.Output();
}

TEST(GuidedStation, IsLedFromTheBeginningOfThePathIfItAcceptsLate) {
  const Folder folder;
  const std::string file = folder / "expert.mcap";
  WriteStillHand(file, 0.004);
  ServerProgram server("udp");
  ASSERT_TRUE(server.Ready()) << server.Output();
  HeldStation station;
  ASSERT_TRUE(station.UntilForce());
  ReplayerProgram guide({file, "--guide", "held", "--to", "0.2", "--domain", kDomainText});
  ASSERT_TRUE(guide.Says("guiding station held")) << guide.Output();
  station.For(1.0);
  EXPECT_TRUE(guide.Runs()) << guide.Output();
  station.AcceptGuide(0.5);
  EXPECT_EQ(guide.Exit(), 0) << guide.Output();
}

}  // namespace
}  // namespace palpate::test
