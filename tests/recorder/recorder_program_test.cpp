// The recorder as a program, beside a real server and a real station.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "client/recorder/file_summary.h"
#include "client/replayer/score/cut_measures.h"
#include "client/replayer/verify/verify.h"
#include "common/dds/cdr_reader.h"
#include "common/dds/server_lock.h"
#include "common/dds/topics.h"
#include "common/recording/recording_reader.h"
#include "common/recording/split_name.h"
#include "tests/common/recording/samples.h"
#include "tests/integration/rig.h"
#include "tests/recorder/others_readers.h"
#include "tests/support/read_file.h"
#include "tests/support/roudi.h"
#include "tests/support/stall_witness.h"
#include "tests/support/test_domain.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

class RecorderProgram : public Program {
 public:
  RecorderProgram(const std::string& file, const std::string& transport,
                  const std::vector<std::string>& more = {})
      : Program(PALPATE_BIN_DIR "/palpate-record",
                Joined({"-o", file, "--transport", transport, "--domain", std::to_string(kDomain)},
                       more)) {}
  bool Ready() { return Says("recording to "); }
};

class RecorderProgramTest : public testing::Test {
 protected:
  /// Records a station from first to last.
  void RecordAStation(const std::string& transport) {
    ServerProgram server(transport);
    ASSERT_TRUE(server.Ready()) << server.Output();
    RecorderProgram recorder(file_, transport);
    ASSERT_TRUE(recorder.Ready()) << recorder.Output();
    StationProgram station("hand", transport, {"--for", "4", "--json", json_});
    ASSERT_EQ(station.Exit(), 0) << station.Output();
    recorder.Signal(SIGINT);
    EXPECT_EQ(recorder.Exit(), 0) << recorder.Output();
    EXPECT_THAT(recorder.Output(), HasSubstr("dropped 0"));
  }
  void ExpectWholeAndTheSame() {
    const FileSummary summary = Summarise({file_});
    EXPECT_TRUE(summary.complete) << ToText(summary);
    EXPECT_EQ(summary.dropped, 0u);
    EXPECT_EQ(summary.missing, 0u) << ToText(summary);
    EXPECT_EQ(summary.end_reason, "ended by the user");
    EXPECT_TRUE(summary.scenes.at("cube").bundle);
    ASSERT_EQ(summary.sessions.size(), 1u);
    EXPECT_GT(summary.sessions[0].start_sequence, 0u);
    std::map<std::string, std::uint64_t> messages;
    for (const auto& [name, topic] : summary.topics) messages[topic.type] += topic.messages;
    EXPECT_GT(messages["palpate::HapticPose"], 500u);
    EXPECT_GT(messages["palpate::Wrench"], 500u);
    EXPECT_GT(messages["palpate::ToolState"], 30u);
    EXPECT_GE(messages["palpate::LoopStatistics"], 1u);
    EXPECT_GE(messages["palpate::StationStatistics"], 1u);
    EXPECT_GE(messages["palpate::SessionRequest"], 1u);
    EXPECT_GE(messages["palpate::SessionState"], 3u);
    EXPECT_EQ(messages["palpate::SceneBundle"], 1u);
    EXPECT_EQ(messages["palpate::SceneOffer"], 1u);
    const Verification verification = Verify({file_}, {});
    EXPECT_TRUE(verification.good()) << ToText(verification);
    ExpectTheStationsOwnCounts();
  }
  /// What the station published while it ran adds up to its figures at the end.
  void ExpectTheStationsOwnCounts() {
    RecordingReader reader({file_});
    std::map<std::string, std::uint64_t> sums;
    for (RecordedSample sample{}; reader.Next(sample);) {
      wire::StationStatistics s{};
      if (sample.type != RecordedType::kStationStatistics || !sample.To(s)) continue;
      sums["calls"] += s.ticks;
      sums["slewed"] += s.slewed;
      sums["braked"] += s.braked;
      sums["faded"] += s.faded;
      sums["disabled"] += s.disabled;
    }
    const auto told = nlohmann::json::parse(ReadWholeFile(json_)).at("limiter");
    for (const auto& [name, sum] : sums) EXPECT_EQ(sum, told.at(name)) << name;
    EXPECT_GT(sums["disabled"], 0u);
  }

  Folder folder_;
  std::string file_ = folder_ / "a.mcap", json_ = folder_ / "a.json";
};

TEST_F(RecorderProgramTest, NamesTheDomainsOfThisHostThatHaveAServerWhereItHearsNone) {
  const int other = OwnDomain();
  const ServerLock lock(other);
  RecorderProgram recorder(file_, "udp", {"--for", "1"});
  EXPECT_EQ(recorder.Exit(), 0);
  EXPECT_THAT(recorder.Output(), HasSubstr("no server found in domain " + std::to_string(kDomain) +
                                           " of this host for 1 s"));
  EXPECT_THAT(recorder.Output(), HasSubstr("--domain " + std::to_string(other) + " is "));
}

TEST_F(RecorderProgramTest, RecordsEverySampleOverUdpAndOthersReadThem) {
  RecordAStation("udp");
  if (HasFatalFailure()) return;
  EXPECT_EQ(std::filesystem::status(file_).permissions() & std::filesystem::perms::others_all,
            std::filesystem::perms::none);
  ExpectWholeAndTheSame();
  const auto others = ReadByOthers(file_);
  if (!others) GTEST_SKIP() << "deploy/setup --for tests fetches MCAP's readers";
  EXPECT_EQ((*others)["different"], 0);
  EXPECT_EQ((*others)["messages"].size(), Summarise({file_}).messages);
  EXPECT_EQ((*others)["indexed"], (*others)["messages"].size());
}

TEST_F(RecorderProgramTest, RecordsEverySampleOverSharedMemory) {
  RouDi roudi;
  RecordAStation("shm");
  if (HasFatalFailure()) return;
  ExpectWholeAndTheSame();
}

TEST_F(RecorderProgramTest, RecordsForViewersOrOfAStationAloneWhereTold) {
  ServerProgram server("udp");
  ASSERT_TRUE(server.Ready()) << server.Output();
  RecorderProgram recorder(file_, "udp", {"--no-loop", "--no-bundle"});
  RecorderProgram of_another(folder_ / "other.mcap", "udp", {"--station", "other"});
  ASSERT_TRUE(recorder.Ready()) << recorder.Output();
  ASSERT_TRUE(of_another.Ready()) << of_another.Output();
  StationProgram station("hand", "udp", {"--for", "1"});
  ASSERT_EQ(station.Exit(), 0) << station.Output();
  for (RecorderProgram* each : {&recorder, &of_another}) {
    each->Signal(SIGTERM);
    EXPECT_EQ(each->Exit(), 0) << each->Output();
  }
  const FileSummary others = Summarise({folder_ / "other.mcap"});
  EXPECT_TRUE(others.sessions.empty());
  EXPECT_TRUE(others.scenes.at("cube").bundle);
  EXPECT_FALSE(others.topics.contains("palpate/tool_state"));
  EXPECT_THAT(ToText(others), HasSubstr("of no station but other"));
  const FileSummary summary = Summarise({file_});
  for (const auto& [name, topic] : summary.topics) {
    EXPECT_NE(topic.type, "palpate::HapticPose");
    EXPECT_NE(topic.type, "palpate::SceneBundle");
  }
  EXPECT_TRUE(summary.topics.contains("palpate/tool_state"));
  EXPECT_FALSE(summary.scenes.at("cube").bundle);
}

/// A server with a block that burs cut.
class CutTest : public RecorderProgramTest {
 protected:
  explicit CutTest(const std::vector<std::string>& burs) {
    std::string tools;
    for (const std::string& bur : burs) {
      tools += (tools.empty() ? "" : ", ") + std::string(R"({"name": ")") + bur + R"(",
        "mesh": {"shape": "bur", "kind": "ball", "diameter_mm": 1}, "leaves": 64,
        "start": {"position_mm": [0, 2, 0]}})";
    }
    const std::string scene = Write("block.json", R"({"tools": [)" + tools + R"(], "objects": [
      {"name": "block", "mesh": {"shape": "box", "size_m": [0.006, 0.002, 0.004]},
       "grid_um": 100, "material": {"cutting_pressure_MPa": 0.1}}]})");
    server_.emplace("udp", std::vector<std::string>{scene});
    EXPECT_TRUE(server_->Ready()) << server_->Output();
  }
  std::string Write(const std::string& name, const std::string& text) const {
    WriteBytes(folder_ / name, {text.begin(), text.end()});
    return folder_ / name;
  }
  /// Rows of time [s] and the hand's place along x and y [mm].
  std::string Script(const std::string& name,
                     const std::vector<std::array<double, 3>>& keys) const {
    std::string text;
    for (const auto& [t, x, y] : keys) {
      text += fmt::format(R"({}{{"t": {}, "position_mm": [{}, {}, 0]}})", text.empty() ? "" : ", ",
                          t, x, y);
    }
    return Write(name, R"({"keys": [)" + text + "]}");
  }
  static void Ask(const char* what) {
    Program lesson(PALPATE_BIN_DIR "/palpate-lesson",
                   {what, "block", "--domain", std::to_string(kDomain)});
    EXPECT_EQ(lesson.Exit(), 0) << lesson.Output();
  }
  /// Starts a hand, and waits until its session has begun.
  static std::unique_ptr<Program> Hand(const std::string& id, const std::string& bur,
                                       const std::string& script,
                                       const std::vector<std::string>& more) {
    auto hand = std::make_unique<Program>(
        PALPATE_BIN_DIR "/palpate-station",
        Joined({"--device", "scripted", "--script", script, "--scene", "block", "--tool", bur,
                "--id", id, "--transport", "udp", "--realtime", "off", "--await-recorder",
                "--domain", std::to_string(kDomain)},
               more));
    EXPECT_TRUE(hand->Says("session: ")) << hand->Output();
    return hand;
  }

  std::optional<ServerProgram> server_;
};

struct OneBur : CutTest {
  OneBur() : CutTest({"bur"}) {}
};
struct SeveralBurs : CutTest {
  SeveralBurs() : CutTest({"left", "right", "late"}) {}
};

// Each session continues on what the one before left of the block; the block is made whole while
// the third cuts, and before the fourth.
TEST_F(OneBur, IsRecordedSoThatWhatItCutsIsTheSameBitsAgain) {
  const std::string script = Script("groove.json", {{0.0, -2, 1.5}, {0.8, -2, 0.2}, {1.8, 1, 0.2}});
  struct Groove {
    double sum_N = 0.0, poses = 0.0, end_m = -1.0;
    double mean_N() const { return sum_N / poses; }
  };
  std::map<std::string, Groove> along;  // in the same place: a busy host sends fewer poses
  std::size_t blocks = 0;
  double seconds = 0.0;
  // Spoilt where a hand lost its session, or did not come to its groove's end in its time.
  ASSERT_TRUE(Shown([&](StallWitness& witness) {
    std::filesystem::remove(file_);
    Ask("whole");
    RecorderProgram recorder(file_, "udp");
    EXPECT_TRUE(recorder.Ready()) << recorder.Output();
    seconds += 2.0;
    bool lost = false;
    for (const std::string station : {"one", "two", "three", "four"}) {
      if (station == "four") Ask("whole");
      const auto hand = Hand(station, "bur", script, {"--for", std::to_string(seconds)});
      witness.Watch(hand->id());
      if (station == "three") Ask("whole");
      EXPECT_EQ(hand->Exit(), 0) << hand->Output();
      lost = lost || hand->Output().find("asking again") != std::string::npos;
    }
    recorder.Signal(SIGINT);
    EXPECT_EQ(recorder.Exit(), 0) << recorder.Output();

    along.clear();
    blocks = 0;
    RecordingReader reader({file_});
    for (RecordedSample sample{}; reader.Next(sample);) {
      wire::HapticPose pose{};
      wire::Wrench wrench{};
      blocks += sample.type == RecordedType::kSolidBlock;
      if (sample.To(pose)) {
        double& end_m = along[dds::SessionOfTopic(*sample.topic)->first].end_m;
        end_m = std::max(end_m, pose.position_m[0]);
      }
      if (!sample.To(wrench)) continue;
      Groove& groove = along[dds::SessionOfTopic(*sample.topic)->first];
      if (std::abs(wrench.graphic_position_m[0] + 0.5e-3) > 1.2e-3) continue;
      groove.sum_N += wire::ToWrench(wrench).force.norm();
      groove.poses += 1.0;
    }
    if (HasFailure()) return Attempt::kFailed;
    const bool is_whole =
        std::ranges::all_of(along, [](const auto& one) { return one.second.end_m > 0.99e-3; });
    return is_whole && !lost && along.size() == 4 ? Attempt::kShown : Attempt::kSpoilt;
  }));
  if (IsSkipped()) return;
  EXPECT_GT(blocks, 20u);
  EXPECT_GT(along["one"].mean_N(), 0.015);
  EXPECT_LT(along["two"].mean_N(), 0.5 * along["one"].mean_N());  // it follows the groove
  EXPECT_GT(along["four"].mean_N(), 0.8 * along["one"].mean_N());
  VerifyOptions options;
  const Verification verification = Verify({file_}, options);
  EXPECT_TRUE(verification.good()) << ToText(verification);
  ASSERT_EQ(verification.sessions.size(), 4u);
  std::map<std::string, TissueCut> cut;
  for (const SessionVerdict& session : verification.sessions) {
    options.whose = std::pair(session.station, session.run);
    for (const SessionVerdict& its : Verify({file_}, options).sessions) {
      if (!its.cut) continue;
      const std::vector<TissueCut> tissues = TissuesOf(*its.cut);
      ASSERT_EQ(tissues.size(), 1u);
      EXPECT_EQ(tissues[0].name, "block");
      cut[its.station] = tissues[0];
    }
  }
  ASSERT_EQ(cut.size(), 4u);
  EXPECT_NEAR(cut["one"].before_mm3, 48.0, 0.1);
  EXPECT_GT(cut["one"].removed_mm3(), 1.0);
  // Each bur summed its volumes in an order of its own.
  EXPECT_NEAR(cut["two"].before_mm3, cut["one"].after_mm3, 0.002);
  EXPECT_GT(cut["two"].removed_mm3(), 0.0);
  EXPECT_EQ(cut["four"].before_mm3, cut["one"].before_mm3);
}

// Two cut one groove from both ends.  One is killed and comes back; the block is made whole,
// bookmarked and brought back; a third bur comes late.  The recorder, which splits, ends while they
// cut.
TEST_F(SeveralBurs, AreRecordedSoThatAllIsTheSameBitsAgain) {
  const auto script = [&](const std::string& name, double from, double to) {
    return Script(
        name,
        {{0.0, from, 1.5}, {0.4, from, 0.3}, {1.2, to, -0.2}, {1.6, to, 1.5}, {2.0, from, 1.5}});
  };
  const std::string to_right = script("r.json", -2, 2), to_left = script("l.json", 2, -2);
  RecorderProgram recorder(file_, "udp", {"--split-time", "2"});
  ASSERT_TRUE(recorder.Ready()) << recorder.Output();
  const auto hand = [](const std::string& bur, const std::string& path) {
    return Hand(bur, bur, path, {"--for", "60", "--loop"});
  };
  const auto wait = [](double seconds) {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  };
  auto left = hand("left", to_right);
  const auto right = hand("right", to_left);
  wait(1.3);
  Ask("bookmark");
  left->Signal(SIGKILL);
  wait(0.3);
  left = hand("left", to_right);
  wait(1.0);
  Ask("whole");
  wait(0.6);
  const auto late = hand("late", to_right);
  wait(0.6);
  Ask("back");
  wait(1.0);
  recorder.Signal(SIGINT);
  EXPECT_EQ(recorder.Exit(), 0) << recorder.Output();
  EXPECT_THAT(recorder.Output(), HasSubstr("dropped 0"));

  std::vector<std::string> splits;
  for (const NamedSplit& split : FindSplits(file_)) splits.push_back(split.file);
  EXPECT_GT(splits.size(), 2u);
  const Verification verification = Verify(splits, {});
  EXPECT_TRUE(verification.good()) << ToText(verification);
  EXPECT_GE(verification.sessions.size(), 4u) << "more where a hand was held up and came again";
  std::size_t merged = 0;
  RecordingReader reader(splits);
  for (RecordedSample sample{}; reader.Next(sample);) {
    dds::Owned<wire::CutLog> log;
    if (!sample.To(log.value)) continue;
    for (std::uint32_t i = 0; i < log.value.events._length; ++i) {
      merged += log.value.events._buffer[i].step == palpate_CUT_MERGED;
    }
  }
  EXPECT_GT(merged, 100u);
}

TEST_F(RecorderProgramTest, NeedsAFileAndLeavesThoseThatAreThere) {
  Program without(PALPATE_BIN_DIR "/palpate-record", {});
  EXPECT_EQ(without.Exit(), 2);
  EXPECT_THAT(without.Output(), HasSubstr("-o FILE.mcap"));
  WriteBytes(file_, {1, 2, 3});
  RecorderProgram recorder(file_, "udp");
  EXPECT_EQ(recorder.Exit(), 1);
  EXPECT_THAT(recorder.Output(), HasSubstr("--overwrite"));
  Program info(PALPATE_BIN_DIR "/palpate-record", {"info", file_});
  EXPECT_EQ(info.Exit(), 1);
  EXPECT_THAT(info.Output(), HasSubstr("is not an MCAP file"));

  std::vector<std::uint8_t> bytes = BytesOf(PALPATE_SOURCE_DIR "/tests/replayer/golden/cube.mcap");
  for (const int status : {0, 1}) {
    WriteBytes(file_, bytes);
    Program judged(PALPATE_BIN_DIR "/palpate-record", {"info", file_});
    EXPECT_EQ(judged.Exit(), status) << judged.Output();
    EXPECT_THAT(judged.Output(), HasSubstr(status == 0 ? ": whole\n" : ": DAMAGED\n"));
    bytes[30] ^= 1;
  }
}

}  // namespace
}  // namespace palpate::test
