#include "client/replayer/verify/verify.h"

#include <algorithm>
#include <bit>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>

#include <gmock/gmock.h>

#include "client/replayer/score/cut_measures.h"
#include "client/replayer/score/trial_cut.h"
#include "common/error.h"
#include "common/json/pose_script.h"
#include "common/mcap/mcap_writer.h"
#include "common/recording/recording_reader.h"
#include "common/revision.h"
#include "scenes/catalogue.h"
#include "scenes/files/scene_bundle.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "server/session/servo_loop.h"
#include "tests/common/recording/samples.h"
#include "tests/support/complaint.h"
#include "tests/support/effects_scene.h"
#include "tests/support/milliseconds.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

constexpr std::uint64_t kPoses = 300;
constexpr std::uint64_t kStart = 5;

/// A session as a recorder hears it, and what gets lost.
struct Story {
  std::string scene = "cube";
  std::set<std::uint64_t> server_misses{};                ///< poses
  std::set<std::uint64_t> poses_lost{}, wrenches_lost{};  ///< to the recorder
  bool state_lost = false;
  bool pose_untold = false;        ///< with which forces began: the recorder ended before
  std::uint64_t whole_before = 0;  ///< a pose; 0: never.  Forces begin again 20 poses later
  bool whole_lost = false;
  bool goes_on = false;  ///< when the recorder ends
};

/// On the cube the hand slides along the top face, 1 mm deep.  On the calculus it scrapes.  On a
/// block it presses a bur, which stops from pose 220 to 259.
wire::HapticPose PoseAt(const Scene& scene, std::uint64_t sequence) {
  wire::HapticPose pose{};
  pose.pose_sequence = sequence;
  pose.sample_time_ns = static_cast<std::int64_t>(sequence) * kMs;
  Pose X{Vec3(2e-5 * static_cast<double>(sequence), 0.029, 0.0), Quat::Identity()};
  if (scene.name == "block") {
    X.p = Vec3(0.0, 1.505e-3 - 2e-6 * static_cast<double>(sequence), 0.0);
    pose.buttons = sequence >= 220 && sequence < 260 ? 2 : 0;
  } else if (scene.name == "calculus") {
    static const PoseScript script =
        PoseScript::Load(PALPATE_SOURCE_DIR "/scenes/catalogue/calculus.path.json");
    X = script.At(3.55 + 1e-3 * static_cast<double>(sequence));
  }
  wire::FromPose(X, pose.position_m, pose.orientation_wxyz);
  return pose;
}

void Record(const Story& story, const std::string& file) {
  const Scene scene = LoadScene(story.scene);
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  RecordingWriter writer({.file = file});
  std::vector<std::uint8_t> bytes = PackScene(scene);
  Add(writer, dds::kSceneBundleTopic, SampleBundle(bytes, scene.name), kMs);

  ServoLoop loop(model);
  const wire::HapticPose start = PoseAt(scene, kStart);
  StepWorkspace workspace(model);
  const Pose X_WG = ResolveStart(model, wire::ToPose(start), workspace).X_WG;
  const auto say_start = [&](std::uint64_t sequence, const Pose& X, std::int64_t now_ns,
                             wire::SessionPhase phase = palpate_SESSION_ACTIVE) {
    wire::SessionState state = SampleState("hand", 9);
    state.phase = phase;
    wire::FromText(scene.name, state.scene);
    wire::FromText(scene.tools.front().name, state.tool);
    state.start_sequence = sequence;
    wire::FromPose(X, state.start_position_m, state.start_orientation_wxyz);
    Add(writer, dds::kSessionStateTopic, state, now_ns);
  };
  for (std::uint64_t i = 1; i <= kPoses; ++i) {
    const wire::HapticPose pose = PoseAt(scene, i);
    const std::int64_t now_ns = static_cast<std::int64_t>(i) * kMs;
    if (!story.poses_lost.contains(i)) Add(writer, dds::PoseTopic("hand", 9), pose, now_ns);
    if (story.server_misses.contains(i)) continue;
    if (i == kStart) loop.Start(X_WG);
    if (i == story.whole_before) {
      loop.MakeWhole();
      wire::LoopWhole whole{};
      wire::FromText("hand", whole.station);
      whole.run = 9;
      whole.number = 1;
      whole.pose_sequence = i;
      if (!story.whole_lost) Add(writer, dds::kLoopWholeTopic, whole, now_ns);
    }
    if (story.whole_before != 0 && i == story.whole_before + 20) {
      loop.Start(wire::ToPose(pose));
      say_start(i, wire::ToPose(pose), now_ns);
    }
    wire::Wrench wrench{};
    loop.OnPose(pose, wrench);
    if (!story.wrenches_lost.contains(i)) Add(writer, dds::WrenchTopic("hand", 9), wrench, now_ns);
  }
  const auto end_ns = static_cast<std::int64_t>(kPoses) * kMs;
  if (!story.state_lost) say_start(story.pose_untold ? 0 : kStart, X_WG, end_ns);
  if (!story.state_lost && !story.goes_on) say_start(0, X_WG, end_ns, palpate_SESSION_ENDED);
  writer.Close("");
}

/// Copies a recording; `change` may alter a sample's bytes.
template <class Change>
void Copy(const std::string& from, const std::string& to, Change change) {
  RecordingReader reader({from});
  RecordingWriter writer({.file = to});
  RecordedSample sample{};
  while (reader.Next(sample)) {
    std::vector<std::uint8_t> cdr(sample.cdr.begin(), sample.cdr.end());
    change(sample, cdr);
    writer.Add(*sample.topic, sample.type, sample.log_time_ns, cdr);
  }
  writer.Close("");
}

/// Copies a recording's samples and none of its recorder's metadata.
void CopySamples(const std::string& from, const std::string& to) {
  RecordingReader reader({from});
  mcap::Writer writer(to, "test");
  std::map<std::string, std::uint16_t> channels;
  for (RecordedSample sample{}; reader.Next(sample);) {
    const auto [channel, is_new] = channels.try_emplace(*sample.topic);
    if (is_new) {
      const std::uint16_t schema = writer.AddSchema(SchemaName(sample.type), "omgidl", "a text");
      channel->second = writer.AddChannel(schema, *sample.topic, "cdr");
    }
    writer.Write(channel->second, 0, sample.log_time_ns, sample.log_time_ns, sample.cdr);
  }
  writer.Close();
}

class VerifyTest : public testing::Test {
 protected:
  /// Verifies a complete recording in which `change` has altered the samples of type T for which it
  /// returns true.
  template <class T>
  Verification Tampered(const std::function<bool(T&)>& change, const Story& story = {}) {
    const std::string tampered = folder_ / "tampered.mcap";
    Record(story, file_);
    Copy(file_, tampered, [&](const RecordedSample& sample, std::vector<std::uint8_t>& cdr) {
      T value{};
      if (!sample.To(value) || !change(value)) return;
      cdr.clear();
      dds::ToCdr(value, cdr);
    });
    return Verify({tampered}, {});
  }
  SessionVerdict VerdictOf(const Story& story) {
    std::filesystem::remove(file_);
    Record(story, file_);
    return Only(Verify({file_}, {}));
  }
  static SessionVerdict Only(const Verification& verification) {
    EXPECT_THAT(verification.sessions, SizeIs(1));
    return verification.sessions.empty() ? SessionVerdict{} : verification.sessions.front();
  }

  /// A scene with a block that a bur cuts.
  std::string Block() const {
    const std::string block = folder_ / "block.json";
    std::ofstream(block) << R"({"tools": [{"name": "bur", "leaves": 8, "bur": "001/014",
      "speed_rpm": 200000}], "objects": [{"name": "block", "grid_um": 100,
      "mesh": {"shape": "box", "size_m": [0.004, 0.003, 0.004]}, "material": {
      "cutting_pressure_MPa": 0.2, "cutting_friction": 0.3}}]})";
    return block;
  }

  /// Verifies the file without its last 100 bytes.
  Verification CutOff() {
    std::vector<std::uint8_t> bytes = BytesOf(file_);
    bytes.resize(bytes.size() - 100);
    WriteBytes(file_, bytes);
    return Verify({file_}, {});
  }

  Folder folder_;
  std::string file_ = folder_ / "good.mcap";
};

std::set<std::uint64_t> UpTo(std::uint64_t last) {
  std::set<std::uint64_t> numbers;
  for (std::uint64_t i = 1; i <= last; ++i) numbers.insert(i);
  return numbers;
}

TEST_F(VerifyTest, ComputesAgainWhatCanBeAndSaysWhereThatEnds) {
  struct Case {
    const char* what;
    Story story;
    std::uint64_t verified;
    const char* ends;  ///< empty: the same to the end
  };
  for (const auto& [what, story, verified, ends] :
       {Case{"nothing is lost", {}, kPoses, ""},
        {"it ended before the pose with which forces began was told",
         {.pose_untold = true},
         kPoses,
         ""},
        {"the server never had some", {.server_misses = {1, 2, 40, 41, 42, 250}}, kPoses - 6, ""},
        {"the recorder missed some",
         {.wrenches_lost = {1, 2, 5, 6, 100, 200, 201}},
         kPoses - 7,
         ""},
        {"a pose is missing", {.poses_lost = {90}}, 89, "pose 90 is not in the recording"},
        {"who had which is a guess",
         {.server_misses = {100}, .wrenches_lost = {101}},
         99,
         "before pose 102"},
        {"it began too late",
         {.poses_lost = UpTo(49), .wrenches_lost = UpTo(49)},
         0,
         "began after its loop"},
        {"no state of the session", {.state_lost = true}, 0, "state"},
        {"no wrench at all",
         {.wrenches_lost = UpTo(kPoses)},
         0,
         "it has 300 poses, but no wrench"}}) {
    SCOPED_TRACE(what);
    const SessionVerdict verdict = VerdictOf(story);
    EXPECT_EQ(verdict.good(), *ends == '\0');
    EXPECT_EQ(verdict.verified, verified);
    EXPECT_EQ(verdict.different, 0u);
    EXPECT_THAT(verdict.ends, *ends == '\0' ? testing::Matcher<std::string>("") : HasSubstr(ends));
  }
}

TEST_F(VerifyTest, ComputesAgainWhatAnEdgeScrapes) {
  const SessionVerdict verdict = VerdictOf({.scene = "calculus"});
  EXPECT_TRUE(verdict.good()) << verdict.ends;
  EXPECT_EQ(verdict.verified, kPoses);
}

TEST_F(VerifyTest, ComputesEffectsAgainAndRefusesAnotherSharedObject) {
  namespace fs = std::filesystem;
  const std::string scene = folder_ / "own/sticky.json", mine = folder_ / "own/mine.so";
  fs::create_directory(folder_ / "own");
  fs::copy(PALPATE_BIN_DIR "/effects/stick.so", mine);
  std::ofstream(scene) << CubeWithEffects(R"({"name": "mine.so"},
      {"name": "moving_spring", "from_mm": [0, 30, 0], "to_mm": [5, 30, 0]})");
  {
    const TrustedEffects own(folder_ / "own");
    Record({.scene = scene, .server_misses = {77}}, file_);
  }
  const auto complaint = [&] { return ComplaintOf([&] { Verify({file_}, {}); }); };
  EXPECT_THAT(complaint(), testing::AllOf(HasSubstr("the recording's scene 'sticky'"),
                                          HasSubstr("effect mine.so"), HasSubstr("was not found")));
  fs::copy(mine, folder_ / "mine.so");
  EXPECT_THAT(complaint(), testing::AllOf(HasSubstr(folder_ / "mine.so"), HasSubstr("--effects ")))
      << "whoever sent the recording may have sent that file, too";
  fs::copy(PALPATE_BIN_DIR "/effects/viscous.so", folder_ / "mine.so",
           fs::copy_options::overwrite_existing);
  {
    const TrustedEffects beside(folder_.path());
    EXPECT_THAT(complaint(), HasSubstr("mine.so is another one (hash "));
  }
  const TrustedEffects own(folder_ / "own");
  SessionVerdict verdict = Only(Verify({file_}, {}));
  EXPECT_TRUE(verdict.good()) << verdict.ends;
  EXPECT_EQ(verdict.verified, kPoses - 1);
  verdict = Only(Verify({file_}, {.scene = scene}));
  EXPECT_TRUE(verdict.good()) << verdict.ends;
}

TEST_F(VerifyTest, RefusesASceneWhoseEffectsAreNotThoseThatWereRecorded) {
  const std::string scene = folder_ / "own.json";
  const auto write = [&](const std::string& effects) {
    std::ofstream(scene) << CubeWithEffects(effects);
  };
  write(R"({"name": "viscous", "damping_N_s_per_m": 5})");
  Record({.scene = scene}, file_);
  const std::string bare = folder_ / "bare.mcap";
  CopySamples(file_, bare);
  EXPECT_TRUE(Only(Verify({bare}, {.scene = scene})).good());
  for (const char* other : {"", R"({"name": "viscous", "damping_N_s_per_m": 4})",
                            R"({"name": "viscous", "damping_N_s_per_m": 5}, {"name": "stick"})"}) {
    write(other);
    for (const std::string& file : {file_, bare}) {
      EXPECT_THAT(ComplaintOf([&] { Verify({file}, {.scene = scene}); }),
                  testing::AllOf(HasSubstr("is not the one that was recorded"),
                                 HasSubstr("which had the effects viscous.so (hash "),
                                 HasSubstr("[[5.0],[0.0]], and it has ")));
    }
  }
}

TEST_F(VerifyTest, MakesTheSceneWholeBeforeTheSamePose) {
  Story story{.scene = Block(), .whole_before = 150};
  SessionVerdict verdict = VerdictOf(story);
  EXPECT_TRUE(verdict.good()) << verdict.ends;
  story.whole_lost = true;
  verdict = VerdictOf(story);
  EXPECT_GT(verdict.different, 0u);
  ASSERT_TRUE(verdict.first.has_value());
  EXPECT_EQ(verdict.first->pose_sequence, 150u);
}

// Only the poses tell what a button did to a bur.
TEST_F(VerifyTest, StopsABurAtTheSamePoses) {
  const auto no_button = [](wire::HapticPose& pose) {
    pose.buttons = 0;
    return true;
  };
  const SessionVerdict verdict = Only(Tampered<wire::HapticPose>(no_button, {.scene = Block()}));
  EXPECT_TRUE(Only(Verify({file_}, {})).good());
  ASSERT_TRUE(verdict.first.has_value());
  EXPECT_EQ(verdict.first->pose_sequence, 220u);
}

TEST_F(VerifyTest, NamesTheTamperedMessageAndItsField) {
  double was = 0.0;
  const Verification verification = Tampered<wire::Wrench>([&](wire::Wrench& wrench) {
    if (wrench.pose_sequence != 217) return false;
    was = wrench.force_N[1];
    wrench.force_N[1] = std::bit_cast<double>(std::bit_cast<std::uint64_t>(was) ^ 1u);
    return true;
  });
  const SessionVerdict verdict = Only(verification);
  EXPECT_FALSE(verification.good());
  EXPECT_EQ(verdict.different, 1u);
  EXPECT_EQ(verdict.verified, kPoses - 1);
  ASSERT_TRUE(verdict.first.has_value());
  EXPECT_EQ(verdict.first->pose_sequence, 217u);
  EXPECT_EQ(verdict.first->field, "force_N[1]");
  EXPECT_NEAR(verdict.first->time_s, 0.216, 1e-9);
  char bits[32];
  std::snprintf(bits, sizeof bits, "0x%016llx",
                static_cast<unsigned long long>(std::bit_cast<std::uint64_t>(was)));
  EXPECT_THAT(verdict.first->computed, HasSubstr(bits));
  EXPECT_THAT(ToText(verification), HasSubstr("pose 217"));
}

TEST_F(VerifyTest, FindsATamperedPoseInItsAnswer) {
  const SessionVerdict verdict = Only(Tampered<wire::HapticPose>([](wire::HapticPose& pose) {
    pose.position_m[1] += pose.pose_sequence == 217 ? 1e-6 : 0.0;
    return pose.pose_sequence == 217;
  }));
  ASSERT_TRUE(verdict.first.has_value());
  EXPECT_EQ(verdict.first->pose_sequence, 217u);
}

TEST_F(VerifyTest, DoesNotPassOverAWrenchWhoseBytesAreNone) {
  const std::string broken = folder_ / "broken.mcap";
  Record({}, file_);
  Copy(file_, broken, [](const RecordedSample& sample, std::vector<std::uint8_t>& cdr) {
    wire::Wrench wrench;
    if (sample.To(wrench) && wrench.pose_sequence == 217) cdr[1] = 0;
  });
  const Verification verification = Verify({broken}, {});
  const SessionVerdict verdict = Only(verification);
  EXPECT_FALSE(verification.good());
  EXPECT_EQ(verdict.broken, 1u);
  EXPECT_EQ(verdict.recorded, kPoses);
  EXPECT_EQ(verdict.verified, kPoses - 1);
}

TEST_F(VerifyTest, RefusesMoreSessionsAtOnceThanServersHave) {
  {
    RecordingWriter writer({.file = file_});
    for (int round = 0; round < 2; ++round) {
      for (std::uint64_t i = 1; i <= 300; ++i) {
        const std::string station = "hand" + std::to_string(i);
        if (round == 0) Add(writer, dds::kSessionStateTopic, SampleState(station, i), kMs);
        Add(writer, dds::PoseTopic(station, i), SamplePose(1), kMs);
      }
    }
    writer.Close("");
  }
  EXPECT_THAT([&] { Verify({file_}, {}); },
              testing::ThrowsMessage<Error>(HasSubstr("more than 256 sessions at once")));
}

TEST_F(VerifyTest, RefusesASceneThatIsNotTheOneOfItsHash) {
  const std::string forged = folder_ / "forged.mcap";
  Record({}, file_);
  {
    RecordingWriter writer({.file = forged});
    AddBundle(writer, {1, 2, 3}, kMs, true);
    writer.Close("");
  }
  EXPECT_THAT(
      [&] {
        Verify({forged, file_}, {});
      },
      testing::ThrowsMessage<Error>(HasSubstr("it is damaged or forged")));
}

TEST_F(VerifyTest, SaysThatAnAnswerComesAgain) {
  const Verification twice = Tampered<wire::Wrench>([](wire::Wrench& wrench) {
    if (wrench.answer != 218) return false;
    wrench.answer = 217;
    return true;
  });
  EXPECT_THAT(Only(twice).ends, HasSubstr("answer 217 is repeated"));
}

TEST_F(VerifyTest, VerifiesWhatIsThereOfARecordingThatWasCutOff) {
  Record({}, file_);
  const Verification verification = CutOff();
  EXPECT_TRUE(verification.good());
  EXPECT_THAT(verification.problems, SizeIs(1));
}

TEST_F(VerifyTest, LeavesOutTheLastWrenchesOfARecordingThatEndedBeforeTheirPoses) {
  const auto expect_left_out = [](const Verification& verification) {
    EXPECT_TRUE(verification.good()) << ToText(verification);
    EXPECT_EQ(Only(verification).verified, kPoses - 2);
    EXPECT_EQ(Only(verification).cut_off, 2u);
    EXPECT_THAT(ToText(verification),
                HasSubstr("2 more at its end answer poses after the end of the recording"));
  };
  Record({.poses_lost = {kPoses - 1, kPoses}}, file_);
  EXPECT_FALSE(Verify({file_}, {}).good()) << "what has its session's end lacks no pose";
  expect_left_out(CutOff());
  // Its recorder was told to end while the hand went on.
  std::filesystem::remove(file_);
  Record({.poses_lost = {kPoses - 1, kPoses}, .goes_on = true}, file_);
  expect_left_out(Verify({file_}, {}));
}

TEST_F(VerifyTest, RefusesWhatHasChangedOnTheDisk) {
  Record({}, file_);
  std::vector<std::uint8_t> bytes = BytesOf(file_);
  bytes[bytes.size() / 2] ^= 4;
  WriteBytes(file_, bytes);
  EXPECT_FALSE(Verify({file_}, {}).good());
}

TEST(Difference, SeesEveryBitButThoseOfTheClock) {
  const wire::Wrench wrench = SampleWrench(3);
  int unseen = 0;
  for (std::size_t bit = 0; bit < 8 * sizeof wrench; ++bit) {
    wire::Wrench other = wrench;
    reinterpret_cast<unsigned char*>(&other)[bit / 8] ^= static_cast<unsigned char>(1 << bit % 8);
    unseen += !Difference(wrench, other).has_value();
  }
  EXPECT_EQ(unseen, 64) << "step_time_s";
  wire::Wrench other = wrench;
  other.row[4][2] = 0.0;
  EXPECT_EQ(Difference(wrench, other)->field, "row[4][2]");
}

TEST(VerifyWrenches, ADifferenceTellsWhichBuildsThePhysicsWere) {
  Verification verification;
  verification.physics = "0123456789ab";
  verification.sessions.emplace_back();
  verification.sessions[0].recorded = verification.sessions[0].verified = 1;
  EXPECT_FALSE(verification.differs());
  EXPECT_THAT(ToText(verification), Not(HasSubstr("0123456789ab")));
  verification.sessions[0].different = 1;
  EXPECT_TRUE(verification.differs());
  EXPECT_THAT(ToText(verification), HasSubstr("deploy/revision 0123456789ab"));
  EXPECT_THAT(ToText(verification), HasSubstr(kPhysicsRevision));
  verification.physics = kPhysicsRevision;
  EXPECT_THAT(ToText(verification), Not(HasSubstr("deploy/revision"))) << "it would be in vain";
}

// The physics gives what it gave when the golden recordings were made, on every machine.  After an
// intended change: cmake --build --preset release --target golden
std::string FileOf(const std::string& scene) {
  return PALPATE_SOURCE_DIR "/tests/replayer/golden/" + scene + ".mcap";
}

HandPath HandOf(const SessionVerdict& session) {
  HandPath hand;
  hand.station = session.station;
  hand.run = session.run;
  hand.tool_name = session.tool;
  return hand;
}

/// Where the tool's path alone is enough to tell what it cut, the volumes have the same bits.
void ExpectTheSweepToBeThat(const std::string& file, const SessionVerdict& computed) {
  const SolidsCut& again = *computed.cut;
  if (again.after.empty()) return;
  const auto swept = SweptIn(file, HandOf(computed), {again.scene, again.objects});
  // In these two the tool begins inside the material, and frees itself by many sub-steps.
  EXPECT_EQ(swept.has_value(), computed.scene != "caries" && computed.scene != "calculus");
  if (!swept) return;
  const auto tissues = TissuesOf(*swept), by_steps = TissuesOf(again);
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    EXPECT_EQ(tissues[i].after_mm3, by_steps[i].after_mm3) << tissues[i].name;
  }
}

class GoldenRecording : public testing::TestWithParam<std::string> {};

TEST_P(GoldenRecording, GivesTheSameBits) {
  if (!std::filesystem::exists(FileOf(GetParam()))) {
    GTEST_SKIP() << "has no golden recording: whoever has its meshes makes one with "
                    "'make_golden tests/replayer/golden "
                 << GetParam() << "'";
  }
  try {
    const Verification verification = Verify({FileOf(GetParam())}, {.whose = {{"golden", 1}}});
    EXPECT_TRUE(verification.good()) << ToText(verification);
    ASSERT_GE(verification.sessions.size(), 1u);
    EXPECT_EQ(verification.sessions[0].scene, GetParam());
    ExpectTheSweepToBeThat(FileOf(GetParam()), verification.sessions[0]);
  } catch (const Error& error) {
    if (std::string(error.what()).find("is not installed") == std::string::npos) throw;
    GTEST_SKIP() << error.what();
  }
}

std::string NameOf(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::ranges::replace(name, '-', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Catalogue, GoldenRecording, testing::ValuesIn(CatalogueNames()), NameOf);

/// Copies the recording of two hands, the second's samples so much later, without those that
/// `leave_out` chooses.
void CopyHands(const std::string& to, std::int64_t later_ns,
               const std::function<bool(const RecordedSample&)>& leave_out) {
  RecordingReader reader({FileOf("handshake")});
  std::multimap<std::int64_t, std::pair<std::string, RecordedSample>> samples;
  std::deque<std::vector<std::uint8_t>> bytes;
  for (RecordedSample sample{}; reader.Next(sample);) {
    if (leave_out(sample)) continue;
    const bool second = sample.topic->find("golden_2") != std::string::npos;
    bytes.emplace_back(sample.cdr.begin(), sample.cdr.end());
    sample.cdr = bytes.back();
    samples.emplace(sample.log_time_ns + (second ? later_ns : 0), std::pair(*sample.topic, sample));
  }
  RecordingWriter writer({.file = to});
  for (const auto& [time_ns, sample] : samples) {
    writer.Add(sample.first, sample.second.type, time_ns, sample.second.cdr);
  }
  writer.Close("");
}

TEST_F(VerifyTest, MakesTheStepsOfTwoHandsInTheirOrder) {
  const std::string file = folder_ / "hands.mcap";
  for (const std::int64_t later : {0, 40, 1000}) {
    std::filesystem::remove(file);
    CopyHands(file, later * kMs, [](const RecordedSample&) { return false; });
    const Verification verification = Verify({file}, {});
    EXPECT_TRUE(verification.good()) << later << "\n" << ToText(verification);
    EXPECT_EQ(verification.sessions.size(), 2u);
  }
}

TEST_F(VerifyTest, SaysWhichStepOfAnotherHandIsMissing) {
  const std::string file = folder_ / "hands.mcap";
  int number = 0;
  CopyHands(file, 0, [&](const RecordedSample& sample) {
    wire::Wrench wrench{};
    return sample.To(wrench) && sample.topic->find("golden_2") != std::string::npos &&
           ++number == 100;
  });
  const Verification verification = Verify({file}, {});
  EXPECT_FALSE(verification.good());
  EXPECT_FALSE(verification.differs());
  EXPECT_EQ(verification.sessions[0].verified, 100u);
  EXPECT_THAT(verification.sessions[0].ends, HasSubstr("step 200 of the scene's hands, another's"));
}

TEST_F(VerifyTest, LeavesNothingToTheSweepWhereThePoseWithWhichForcesBeganIsNotTold) {
  const std::string untold = folder_ / "untold.mcap";
  Copy(FileOf("crown"), untold, [](const RecordedSample& sample, std::vector<std::uint8_t>& cdr) {
    wire::SessionState state{};
    if (!sample.To(state)) return;
    state.start_sequence = 0;
    cdr.clear();
    dds::ToCdr(state, cdr);
  });
  const Verification verification = Verify({untold}, {.whose = {{"golden", 1}}});
  EXPECT_TRUE(verification.good()) << ToText(verification);
  ASSERT_EQ(verification.sessions.size(), 1u);
  const SessionVerdict& computed = verification.sessions[0];
  EXPECT_FALSE(SweptIn(untold, HandOf(computed), {computed.cut->scene, computed.cut->objects}));
}

TEST(GoldenRecordings, AreThereForEverySceneWhoseMeshesAre) {
  for (const std::string& scene : CatalogueNames()) {
    if (scene == "dragon-buddha") continue;  // the Buddha does not come with the project
    EXPECT_TRUE(std::filesystem::exists(FileOf(scene))) << scene;
  }
}

}  // namespace
}  // namespace palpate::test
