// A scene that only the server has: stations and mice learn about it from the server.
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "common/dds/cdr_reader.h"
#include "common/recording/recording_reader.h"
#include "tests/integration/rig.h"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

constexpr char kScene[] = R"({
  "tools": [{"name": "ball", "mesh": {"shape": "sphere", "radius_m": 0.004}, "leaves": 1,
             "start": {"position_mm": [0, 40, 0]}}],
  "objects": [{"name": "box", "mesh": {"shape": "box", "size_m": [0.04, 0.02, 0.03]},
               "leaves": 64}]})";
// The ball is 2 mm below the box's top face.
constexpr char kHand[] = R"({"keys": [
  {"t": 0, "position_mm": [0, 30, 0], "label": "own approach"},
  {"t": 1, "position_mm": [0, 12, 0], "label": "own press"},
  {"t": 2, "position_mm": [5, 12, 0], "label": "own slide"}]})";

/// A pyramid of ASCII STL, 20 units wide and 14 high.
std::string Pyramid() {
  const char* const kBase[] = {"-10 0 -10", "-10 0 10", "10 0 10", "10 0 -10"};
  std::string text = "solid tooth\n";
  const auto facet = [&](const char* a, const char* b, const char* c) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const char* corner : {a, b, c}) text += std::string("vertex ") + corner + "\n";
    text += "endloop\nendfacet\n";
  };
  facet(kBase[0], kBase[2], kBase[1]);
  facet(kBase[0], kBase[3], kBase[2]);
  for (int i = 0; i < 4; ++i) facet(kBase[i], kBase[(i + 1) % 4], "0 14 0");
  return text + "endsolid tooth\n";
}

/// The server's files lie in a folder that is gone when stations come.
struct OwnScene : testing::Test {
  const fs::path folder =
      fs::path(testing::TempDir()) / ("palpate_own_" + std::to_string(getpid()));
  const std::string json = testing::TempDir() + "palpate_own_" + std::to_string(getpid()) + ".json";
  std::unique_ptr<Program> server;

  OwnScene() {
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  ~OwnScene() override {
    fs::remove_all(folder);
    fs::remove(json);
  }

  void Write(const char* name, const std::string& text) { std::ofstream(folder / name) << text; }

  static std::vector<std::string> Here(std::vector<std::string> words) {
    words.insert(words.end(),
                 {"--realtime", "off", "--transport", "udp", "--domain", std::to_string(kDomain)});
    return words;
  }
  void Serve(std::vector<std::string> words) {
    server = std::make_unique<Program>(PALPATE_BIN_DIR "/palpate-server", Here(std::move(words)));
    ASSERT_TRUE(server->Says("ready: ", 60.0) && server->Says("\n")) << server->Output();
    fs::remove_all(folder);
  }
  std::unique_ptr<Program> Station(std::vector<std::string> words,
                                   const std::string& name = "hand") {
    words.insert(words.end(), {"--id", name, "--no-table"});
    return std::make_unique<Program>(PALPATE_BIN_DIR "/palpate-station", Here(std::move(words)));
  }
  /// What a station felt, read from its --json file once it has ended.
  nlohmann::json Felt() const {
    std::ifstream in(json);
    return nlohmann::json::parse(in);
  }
};

TEST_F(OwnScene, IsFeltByAStationThatNamesItOrItsFile) {
  Write("mine.json", kScene);
  Serve({"--scene", (folder / "mine.json").string()});
  for (const std::string scene : {"mine", "./mine.json"}) {
    const auto station =
        Station({"--device", "scripted", "--scene", scene, "--for", "5", "--json", json});
    EXPECT_EQ(station->Exit(60.0), 0) << station->Output();
    EXPECT_THAT(station->Output(),
                HasSubstr("the server made a hand for 'ball' (palpate-server --hand-seed 1)"));
    const nlohmann::json felt = Felt();
    EXPECT_EQ(felt["scene"], "mine");
    EXPECT_EQ(felt["tool"], "ball");
    EXPECT_NEAR(felt["force_N_max"], 3.0, 0.5) << "3 mm deep, at 1 N/mm";
  }
}

TEST_F(OwnScene, GivesItsScriptToStationsThatHaveNoFileOfIt) {
  Write("mine.json", kScene);
  Write("mine.path.json", kHand);
  Serve({"--scene", (folder / "mine.json").string()});
  const auto station =
      Station({"--device", "scripted", "--scene", "mine", "--for", "4", "--json", json});
  EXPECT_EQ(station->Exit(60.0), 0) << station->Output();
  EXPECT_THAT(station->Output(), HasSubstr("own slide"));
  EXPECT_THAT(station->Output(), Not(HasSubstr("made a hand")));
  EXPECT_NEAR(Felt()["force_N_max"], 2.0, 0.3);
}

TEST_F(OwnScene, IsHeldWithTheMouseWhereTheServerSaysThatAHandBegins) {
  Write("mine.json", kScene);
  Serve({"--scene", (folder / "mine.json").string()});
  // Its input stays open for a while without a line.
  Program mouse("/bin/sh", {"-c", "sleep 3 | " PALPATE_BIN_DIR
                                  "/palpate-station --device mouse --scene mine --id m --no-table "
                                  "--realtime off --transport udp --domain " +
                                      std::to_string(kDomain)});
  EXPECT_TRUE(mouse.Says("session: tool 'ball' of scene 'mine'")) << mouse.Output();
  EXPECT_TRUE(server->Says("station m: active")) << server->Output();
  EXPECT_EQ(mouse.Exit(), 0) << mouse.Output();
}

TEST_F(OwnScene, IsMadeOfAMeshAndFeltAtOnce) {
  Write("tooth.stl", Pyramid());
  const std::string mesh = (folder / "tooth.stl").string();
  Serve({mesh});
  const std::string said = server->Output();
  EXPECT_THAT(said, HasSubstr("unit: mm, guessed by the size, so it is 20 x 14 x 20 mm"));
  EXPECT_THAT(said, HasSubstr("a ball of 1 mm radius, a twentieth of the longest side (--ball MM"));
  EXPECT_THAT(said, HasSubstr("contact: by the mesh's own triangles, hard, without friction"));
  EXPECT_THAT(said, HasSubstr("scenes tooth;"));
  const auto station =
      Station({"--device", "simulated", "--scene", "tooth.stl", "--for", "6", "--json", json});
  EXPECT_EQ(station->Exit(60.0), 0) << station->Output();
  const nlohmann::json felt = Felt();
  EXPECT_EQ(felt["scene"], "tooth");
  EXPECT_GT(felt["contact_fraction"], 0.2);
  EXPECT_GT(felt["force_N_max"], 0.1);
}

// The box rises under a hand that stands still: it is felt, published, recorded and verified where
// it is.
TEST_F(OwnScene, MovesByItselfAndIsRecordedWhereItIs) {
  Write("lift.json", R"({
  "tools": [{"name": "ball", "mesh": {"shape": "sphere", "radius_m": 0.004}, "leaves": 1,
             "start": {"position_mm": [0, 20, 0]}}],
  "objects": [{"name": "box", "mesh": {"shape": "box", "size_m": [0.04, 0.02, 0.03]}, "moved": "lift"}],
  "moved": [{"name": "lift", "keys": [{"t": 0}, {"t": 1, "shift_mm": [0, 10, 0]}]}]})");
  Write("lift.path.json",
        R"({"keys": [{"t": 0, "position_mm": [0, 20, 0]}, {"t": 3, "position_mm": [0, 20, 0]}]})");
  Serve({"--scene", (folder / "lift.json").string()});
  const fs::path file = fs::path(json).replace_extension(".mcap");
  Program recorder(PALPATE_BIN_DIR "/palpate-record", {"-o", file.string(), "--transport", "udp",
                                                       "--domain", std::to_string(kDomain)});
  ASSERT_TRUE(recorder.Says("recording")) << recorder.Output();
  const auto station =
      Station({"--device", "scripted", "--scene", "lift", "--for", "3", "--await-recorder"});
  EXPECT_EQ(station->Exit(), 0) << station->Output();
  recorder.Signal(SIGINT);
  EXPECT_EQ(recorder.Exit(), 0) << recorder.Output();

  double highest = 0.0, force = 0.0;
  RecordingReader reader({file.string()});
  for (RecordedSample sample{}; reader.Next(sample);) {
    dds::Owned<wire::MovedState> moved;
    wire::ToolState tool{};
    if (sample.To(moved.value)) {
      ASSERT_EQ(moved.value.moved._length, 1u);
      EXPECT_STREQ(moved.value.scene, "lift");
      highest = moved.value.moved._buffer[0].position_m[1];
    }
    if (sample.To(tool)) force = tool.force_N[1];
  }
  EXPECT_NEAR(highest, 0.010, 1e-9);
  EXPECT_NEAR(force, 4.0, 0.01);
  Program replay(PALPATE_BIN_DIR "/palpate-replay", {file.string(), "--verify"});
  EXPECT_EQ(replay.Exit(60.0), 0) << replay.Output();
  EXPECT_THAT(replay.Output(), HasSubstr("verified, bit for bit"));
  fs::remove(file);
}

// Two hands press a box each against the other's; then one is killed.
TEST_F(OwnScene, LetsTwoHandsFeelEachOtherAndSurviveEachOther) {
  Write("pair.json", R"({
  "tools": [{"name": "left", "mesh": {"shape": "box", "size_m": [0.02, 0.02, 0.02]}, "leaves": 64,
             "start": {"position_mm": [-20, 20, 0]}},
            {"name": "right", "mesh": {"shape": "box", "size_m": [0.02, 0.02, 0.02]}, "leaves": 64,
             "start": {"position_mm": [20, 20, 0]}}],
  "objects": [{"name": "floor", "mesh": {"shape": "box", "size_m": [0.1, 0.02, 0.1]},
               "pose": {"position_mm": [0, -30, 0]}}],
  "hands_meet": true})");
  Write("pair.left.path.json", R"({"keys": [{"t": 0, "position_mm": [-20, 20, 0]},
        {"t": 1, "position_mm": [-8, 20, 0]}, {"t": 20, "position_mm": [-8, 20, 0]}]})");
  Write("pair.right.path.json", R"({"keys": [{"t": 0, "position_mm": [20, 20, 0]},
        {"t": 1, "position_mm": [9, 20, 0]}, {"t": 20, "position_mm": [9, 20, 0]}]})");
  Serve({"--scene", (folder / "pair.json").string()});
  const fs::path file = fs::path(json).replace_extension(".mcap");
  Program recorder(PALPATE_BIN_DIR "/palpate-record", {"-o", file.string(), "--transport", "udp",
                                                       "--domain", std::to_string(kDomain)});
  ASSERT_TRUE(recorder.Says("recording")) << recorder.Output();
  const auto hand = [&](const char* tool, const char* seconds) {
    return Station({"--device", "scripted", "--scene", "pair", "--tool", tool, "--for", seconds,
                    "--await-recorder"},
                   tool);
  };
  const auto left = hand("left", "7"), right = hand("right", "60");
  ASSERT_TRUE(left->Says("session: tool 'left'") && right->Says("session: tool 'right'"))
      << server->Output();
  std::this_thread::sleep_for(std::chrono::seconds(4));
  right->Signal(SIGKILL);
  EXPECT_EQ(left->Exit(30.0), 0) << left->Output();
  EXPECT_EQ(hand("right", "2")->Exit(30.0), 0);  // alone, where both had been
  recorder.Signal(SIGINT);
  EXPECT_EQ(recorder.Exit(), 0) << recorder.Output();

  double most = 0.0, last = -1.0, jump = 0.0;
  RecordingReader reader({file.string()});
  std::uint32_t both = 0;
  for (RecordedSample sample{}; reader.Next(sample);) {
    wire::Wrench wrench{};
    if (!sample.To(wrench) || sample.topic->find("left") == std::string::npos) continue;
    const double force = -wrench.force_N[0];
    if (last >= 0.0) jump = std::max(jump, std::abs(force - last));
    last = force;
    most = std::max(most, force);
    both |= wrench.hands;
  }
  EXPECT_EQ(both, 3u);
  EXPECT_NEAR(most, 1.5, 0.02) << "3 mm into each other, by two springs of 1 N/mm";
  EXPECT_EQ(last, 0.0) << "the other let go";
  EXPECT_LT(jump, 0.2) << "without a step";
  Program replay(PALPATE_BIN_DIR "/palpate-replay", {file.string(), "--verify"});
  EXPECT_EQ(replay.Exit(60.0), 0) << replay.Output();
  EXPECT_THAT(replay.Output(), HasSubstr("verified, bit for bit"));
  EXPECT_THAT(replay.Output(), Not(HasSubstr("more at its end")));
  fs::remove(file);
}

}  // namespace
}  // namespace palpate::test
