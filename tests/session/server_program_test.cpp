// What palpate-server says to a person, and how it exits.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <unistd.h>

#include "tests/support/effects_scene.h"
#include "tests/support/program.h"
#include "tests/support/roudi.h"
#include "tests/support/test_domain.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

const int kProgramsDomain = OwnDomain();

Program RunServer(std::vector<std::string> words) {
  return {PALPATE_BIN_DIR "/palpate-server", std::move(words)};
}
/// Adds this run's own domain.
std::vector<std::string> Here(std::vector<std::string> words) {
  words.insert(words.end(), {"--domain", std::to_string(kProgramsDomain)});
  return words;
}

TEST(ServerProgram, IsReadyAndStopsOnASignal) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Program program = RunServer(Here({"--scene", "cube", "--transport", "udp"}));
    ASSERT_TRUE(program.Says("domain " + std::to_string(kProgramsDomain), 60.0))
        << program.Output();
    const std::string& line = program.Output();
    EXPECT_THAT(line, StartsWith("ready: scenes cube; "));
    EXPECT_THAT(line, HasSubstr("UDP (as asked)"));
    EXPECT_THAT(line, HasSubstr("real-time "));
    program.Signal(signal);
    EXPECT_EQ(program.Exit(), 0);
  }
}

/// Writes a scene of one object that is felt by its spheres; returns the file.
std::string SceneOf(const std::string& name, const std::string& mesh, int leaves) {
  const std::string file = testing::TempDir() + name + ".json";
  std::ofstream(file) << R"({"tools":[{"name":"ball","mesh":{"shape":"sphere","radius_m":0.005},
"leaves":1,"start":{"position_mm":[0,80,0]}}],"objects":[{"name":"thing","mesh":)"
                      << mesh << R"(,"leaves":)" << leaves << R"(}],"contact":"spheres"})";
  return file;
}

TEST(ServerProgram, ServesWhatIsNotUsableOnlyWhereItIsToldTo) {
  const std::string scene = SceneOf("bare", R"({"shape":"box","size_m":[0.1,0.1,0.002]})", 2);
  Program refused = RunServer(Here({"--scene", scene, "--transport", "udp"}));
  EXPECT_EQ(refused.Exit(), 1);
  EXPECT_THAT(refused.Output(), HasSubstr("bare.json: is not usable: object thing: "));
  EXPECT_THAT(refused.Output(), HasSubstr("--unusable-too"));
  Program served = RunServer(Here({"--scene", scene, "--transport", "udp", "--unusable-too"}));
  EXPECT_TRUE(served.Says("ready: scenes bare", 60.0)) << served.Output();
  EXPECT_THAT(served.Output(), HasSubstr("bare: not usable: object thing: "));
}

TEST(ServerProgram, RefusesAnEffectThatIsNotAsPassiveAsItSays) {
  const std::string scene = testing::TempDir() + "swirls.json";
  std::ofstream(scene) << CubeWithEffects(R"({"name": "viscous"}, {"name": ")" PALPATE_WRONG_EFFECT
                                          R"(", "way": 6})");
  const std::string folder = std::filesystem::path(PALPATE_WRONG_EFFECT).parent_path();
  Program untrusted = RunServer(Here({"--scene", scene, "--transport", "udp"}));
  EXPECT_EQ(untrusted.Exit(), 1);
  EXPECT_THAT(untrusted.Output(), HasSubstr("--effects " + folder));
  Program refused = RunServer(Here({"--scene", scene, "--transport", "udp", "--effects", folder}));
  EXPECT_EQ(refused.Exit(), 1);
  EXPECT_THAT(refused.Output(),
              HasSubstr("swirls.json: is not usable: effect libpalpate_wrong_effect.so: claims to "
                        "be passive, but gives the hand"));
  EXPECT_THAT(refused.Output(), Not(HasSubstr("viscous")));
}

TEST(ServerProgram, SaysWhatAMeshThatItServesIsNot) {
  const std::string mesh = testing::TempDir() + "open.obj";
  std::ofstream(mesh) << "v 0 0 0\nv 50 0 0\nv 0 50 0\nv 0 0 50\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";
  Program program = RunServer(Here({mesh, "--unit", "mm", "--transport", "udp"}));
  EXPECT_TRUE(program.Says("ready: scenes open", 60.0)) << program.Output();
  EXPECT_THAT(program.Output(), HasSubstr("open: object open: 3 edges are open"));
}

TEST(ServerProgram, NamesTheScenesThatThereAreWhereOneIsUnknown) {
  Program program = RunServer(Here({"--scene", "no-such-scene", "--transport", "udp"}));
  EXPECT_EQ(program.Exit(), 1);
  EXPECT_THAT(program.Output(), HasSubstr("no-such-scene"));
  EXPECT_THAT(program.Output(), HasSubstr("bunny-bunny"));
}

TEST(ServerProgram, RefusesASceneThatIsGivenTwice) {
  const std::string file = PALPATE_SOURCE_DIR "/scenes/catalogue/cube.json";
  Program program = RunServer(Here({"--scene", "cube", "--scene", file, "--transport", "udp"}));
  EXPECT_EQ(program.Exit(60.0), 2);
  EXPECT_THAT(program.Output(), HasSubstr("--scene " + file + ": 'cube' is already served"));
}

TEST(ServerProgram, RefusesRequiredRealTimeWithoutTheRightAndNamesTheLimit) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, to give rights up";
  // Not as another user, who might have no right to read the build folder.
  Program program("/usr/bin/prlimit",
                  Here({"--rtprio=0:0", "setpriv", "--bounding-set", "-sys_nice",
                        PALPATE_BIN_DIR "/palpate-server", "--scene", "cube", "--transport", "udp",
                        "--realtime", "require"}));
  EXPECT_EQ(program.Exit(), 1);
  EXPECT_THAT(program.Output(), HasSubstr("ulimit -r is 0"));
  EXPECT_THAT(program.Output(), HasSubstr("limits.d"));
}

TEST(ServerProgram, ExitsWithTwoWhereTheCommandLineIsWrong) {
  const std::vector<std::vector<std::string>> wrong = {{"--transport", "udp"},
                                                       {"--scene", "cube", "--transport", "tcp"},
                                                       {"--scene", "cube", "--unit", "mm"},
                                                       {"part.stl", "--unit", "furlong"},
                                                       {"part.stl", "--ball", "0"}};
  for (const std::vector<std::string>& words : wrong) {
    Program program = RunServer(Here(words));
    EXPECT_EQ(program.Exit(), 2) << words.back();
    EXPECT_THAT(program.Output(), StartsWith("palpate-server: "));
  }
}

}  // namespace
}  // namespace palpate::test
