// The scripts of deploy/ with stand-ins for the programs that they call.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <unistd.h>

#include "tests/house/source_tree.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"

namespace palpate::house {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

const fs::path kProject = PALPATE_SOURCE_DIR;

/// A repository with only the scripts, and programs that the test writes.
class DeployScripts : public testing::Test {
 protected:
  DeployScripts() {
    fs::create_directories(folder_ / "bin");
    fs::create_directories(folder_ / "deploy");
    for (const std::string part : {"deploy/container", "deploy/cyclonedds"}) {
      fs::copy(kProject / part, folder_ / part);
    }
    for (const std::string file :
         {"deploy/lib.sh", "deploy/setup", "deploy/demo", "deploy/package"}) {
      fs::copy(kProject / file, folder_ / file);
    }
  }
  ~DeployScripts() override { fs::remove_all(folder_); }

  void Write(const std::string& file, const std::string& text) const {
    fs::create_directories((folder_ / file).parent_path());
    std::ofstream(folder_ / file) << text;
  }
  /// Writes a program that the scripts find before the system's; Calls() has how it was called.
  void StandIn(const std::string& name, const std::string& body) const {
    Write("bin/" + name, "#!/bin/bash\necho \"" + name + " $*\" >>" + In("calls") + "\n" + body);
    fs::permissions(folder_ / "bin" / name, fs::perms::owner_all);
  }
  std::string In(const std::string& file) const { return (folder_ / file).string(); }
  std::vector<std::string> Command(std::vector<std::string> words) const {
    words.insert(words.begin(),
                 {"/usr/bin/env", "PATH=" + In("bin") + ":/usr/sbin:/usr/bin:/sbin:/bin"});
    return words;
  }
  std::string Calls() const { return fs::exists(In("calls")) ? ReadWholeFile(In("calls")) : ""; }

  const fs::path folder_ =
      fs::temp_directory_path() / ("palpate_scripts_" + std::to_string(getpid()));
};

TEST_F(DeployScripts, TeachFromWhateverFolderTheyAreCalled) {
  for (const auto& [folder, script] :
       std::map<std::string, std::string>{{"deploy", "./demo"},
                                          {"deploy/container", "./run"},
                                          {"tests", "./run"},
                                          {"tests/benchmarks", "./publish"},
                                          {"", "deploy/demo"}}) {
    const Output help = RunCommand(
        {"sh", "-c", "cd '" + (kProject / folder).string() + "' && " + script + " --help"});
    EXPECT_EQ(help.exit_code, 0) << script << ": " << help.text;
    EXPECT_THAT(help.text, HasSubstr("usage: ")) << script;
  }
}

TEST_F(DeployScripts, FetchAgainWhatWasInterrupted) {
  for (const std::string file : {"package.json", "package-lock.json"}) {
    Write("client/page/" + file, "{}\n");
  }
  // Ends the script that calls it, as Ctrl-C does: some packages are there, but not all.
  StandIn("npm", "mkdir -p \"$2/node_modules\"; kill -KILL $PPID\n");
  RunCommand(Command({In("deploy/setup"), "--for", "page"}));
  EXPECT_FALSE(fs::exists(In("build/page_modules/node_modules")));

  StandIn("npm", "mkdir -p \"$2/node_modules/all\"\n");
  EXPECT_EQ(RunCommand(Command({In("deploy/setup"), "--for", "page"})).exit_code, 0);
  EXPECT_TRUE(fs::exists(In("build/page_modules/node_modules/all")));

  fs::remove(In("calls"));
  EXPECT_EQ(RunCommand(Command({In("deploy/setup"), "--for", "page"})).exit_code, 0);
  EXPECT_EQ(Calls(), "") << "what is whole is not fetched again";
}

TEST_F(DeployScripts, SayWhatAPackageLacksBeforeCPackDoes) {
  StandIn("cpack", "");
  const auto package = [&] {
    const Output output = RunCommand(Command({In("deploy/package"), "--no-build"}));
    EXPECT_EQ(output.exit_code, 1) << output.text;
    EXPECT_THAT(Calls(), Not(HasSubstr("cpack")));
    return output.text;
  };
  EXPECT_EQ(package(), "package: nothing is built in build/release yet; omit --no-build\n");

  Write("build/release/CPackConfig.cmake", "");
  Write("build/page/index.html", "");
  Write("build/release/bin/palpate-server", "");
  Write("build/release/manuals/palpate-server.1.gz", "");
  StandIn("ninja",
          "printf '%s\\n' server/main.cpp.o bin/palpate-server bin/palpate-bench "
          "bin/effects/stick.so\n");
  EXPECT_EQ(package(),
            "package: not built in build/release yet: palpate-bench; omit --no-build "
            "(--no-bench omits palpate-bench)\n");
}

TEST(ApiPages, SayWhatTheyNeed) {
  const Output output = RunCommand({"/usr/bin/env", "PATH=/nowhere", "/usr/bin/cmake", "-P",
                                    (kProject / "server/library/pages/make.cmake").string()});
  EXPECT_NE(output.exit_code, 0);
  EXPECT_THAT(output.text, HasSubstr("deploy/setup --for tests installs it"));
}

/// deploy/container/run with a podman that the test writes; no RouDi runs, and nothing is to be
/// installed.
class ContainerRun : public DeployScripts {
 protected:
  ContainerRun() {
    StandIn("flock", "");
    StandIn("docker", "exit 1\n");
    fs::remove(folder_ / "deploy/setup");
    Write("deploy/setup", "#!/bin/sh\n");
    fs::permissions(folder_ / "deploy/setup", fs::perms::owner_all);
  }
  /// Starts everything and ends it; Calls() has how podman was called.
  void RunAndEnd() const {
    // Like podman's client: what it runs goes on without it.
    StandIn("podman", R"(case $* in
  *iox-roudi*) echo 'RouDi is ready for clients'; exec sleep 1000 ;;
  *palpate-server\ --scene*) echo 'ready: scenes cube'; exec sleep 1000 ;;
  *palpate-viewer\ --http*) echo 'ready: page http://127.0.0.1:8765/'; exec sleep 1000 ;;
esac
)");
    test::Program run("/usr/bin/env",
                      {"PATH=" + In("bin") + ":/usr/sbin:/usr/bin:/sbin:/bin",
                       In("deploy/container/run"), "--engine", "podman", "--no-build"});
    ASSERT_TRUE(run.Says("Ctrl-C ends the containers")) << run.Output();
    run.Signal(SIGTERM);
    EXPECT_EQ(run.Exit(), 0) << run.Output();
  }
};

TEST_F(ContainerRun, EndsTheContainersThatItHasStarted) {
  RunAndEnd();
  const std::string calls = Calls();
  EXPECT_THAT(calls, HasSubstr("--name palpate-roudi"));
  EXPECT_THAT(calls, HasSubstr("--name palpate-server"));
  EXPECT_THAT(calls, HasSubstr("podman stop --ignore --time 5 palpate-viewer"));
  const std::size_t server = calls.find("podman stop --ignore --time 5 palpate-server");
  const std::size_t roudi = calls.find("podman stop --ignore --time 5 palpate-roudi");
  ASSERT_NE(server, std::string::npos) << calls;
  ASSERT_NE(roudi, std::string::npos) << calls;
  EXPECT_LT(server, roudi) << "RouDi ends its clients with it";
}

TEST_F(ContainerRun, GivesEachContainerTheLeastRightsThatItCanDoWith) {
  RunAndEnd();
  std::istringstream calls(Calls());
  int started = 0;
  for (std::string call; std::getline(calls, call);) {
    if (call.find("--name palpate-") == std::string::npos) continue;
    ++started;
    for (const std::string right : {"--cap-drop ALL", "--security-opt no-new-privileges",
                                    "--read-only", "--health-cmd healthy"}) {
      EXPECT_THAT(call, HasSubstr(right));
    }
    // Root without the right to raise limits gives the server two capabilities instead.
    if (call.find("--name palpate-server") == std::string::npos) {
      EXPECT_THAT(call, Not(HasSubstr("--cap-add")));
    }
    EXPECT_THAT(call, Not(HasSubstr("--user 0:")));
    const bool viewer = call.find("--name palpate-viewer") != std::string::npos;
    for (const std::string shared : {"--ipc host", "--pid host", "/tmp:/tmp"}) {
      EXPECT_EQ(call.find(shared) == std::string::npos, viewer) << shared << " in " << call;
    }
  }
  EXPECT_EQ(started, 3);
}

TEST_F(ContainerRun, TakesNoOtherEngineThanTheOneNamed) {
  StandIn("podman", "case $* in *' true') echo 'no rights' >&2; exit 1 ;; esac\n");
  StandIn("buildah", "");
  for (const std::string engine : {"podman", "docker"}) {
    const Output output =
        RunCommand(Command({In("deploy/container/run"), "--engine", engine, "--no-build"}));
    EXPECT_EQ(output.exit_code, 1) << output.text;
    EXPECT_THAT(output.text, HasSubstr("--engine " + engine + ": "));
  }
  EXPECT_THAT(Calls(), Not(HasSubstr("buildah from")));
}

TEST_F(ContainerRun, HandsPodmanTheLimitsOfTheHostAndSaysWhatTheyLack) {
  StandIn("podman", R"(case $* in
  *iox-roudi*) echo 'RouDi is ready for clients'; exec sleep 1000 ;;
  *palpate-server\ --scene*) echo 'ready: scenes cube'; exec sleep 1000 ;;
  *palpate-viewer\ --http*) echo 'ready: page http://127.0.0.1:8765/'; exec sleep 1000 ;;
esac
)");
  StandIn("id", "echo 1000\n");  // not root
  test::Program run(
      "/usr/bin/env",
      {"PATH=" + In("bin") + ":/usr/sbin:/usr/bin:/sbin:/bin", "prlimit", "--rtprio=0:0",
       "--memlock=65536:65536", In("deploy/container/run"), "--engine", "podman", "--no-build"});
  ASSERT_TRUE(run.Says("Ctrl-C ends the containers")) << run.Output();
  run.Signal(SIGTERM);
  EXPECT_EQ(run.Exit(), 0) << run.Output();
  EXPECT_THAT(Calls(), HasSubstr("--ulimit rtprio=0:0 --ulimit memlock=65536:65536"));
  EXPECT_THAT(run.Output(), HasSubstr("podman runs without root, and this user has no real-time"));
  EXPECT_THAT(run.Output(), HasSubstr("in /etc/security/limits.d/palpate.conf, log in again"));
}

TEST(Demo, BuildsTheProgramsThatAreDocumented) {
  const std::string demo = ReadWholeFile((kProject / "deploy/demo").string());
  static const std::regex kBuild("build release (palpate-.*?) \\|\\|");
  std::smatch built;
  ASSERT_TRUE(std::regex_search(demo, built, kBuild));
  const std::string page = ReadWholeFile((kProject / "deploy/programs.md").string());
  static const std::regex kSaid("`deploy/demo` builds ([^;]*);");
  std::smatch said;
  ASSERT_TRUE(std::regex_search(page, said, kSaid));
  const auto programs = [](const std::string& text) {
    static const std::regex kProgram("palpate-[a-z]+");
    return std::vector<std::string>(std::sregex_token_iterator(text.begin(), text.end(), kProgram),
                                    {});
  };
  EXPECT_EQ(programs(said[1]), programs(built[1]));
}

TEST(SharedMemory, IsOneFigureWhereverItIsNamed) {
  const Output needed = RunCommand(
      {"bash", "-c",
       "source '" + (kProject / "deploy/lib.sh").string() + "'; shared_memory_needed_MB"});
  ASSERT_EQ(needed.exit_code, 0) << needed.text;
  const std::string figure = std::to_string(std::stoi(needed.text));
  for (const auto& [file, begin] : std::map<std::string, std::string>{
           {"deploy/REALTIME.md", "`/dev/shm` needs "},
           {"deploy/container/compose.yaml", "The host's must have "},
           {"deploy/cyclonedds/roudi.toml", "/dev/shm must have "}}) {
    EXPECT_THAT(ReadWholeFile((kProject / file).string()), HasSubstr(begin + figure + " MB"))
        << file;
  }
  EXPECT_THAT(ReadWholeFile((kProject / "client/doctor/checks.h").string()),
              HasSubstr("kSharedMemoryNeeded_MB = " + figure + ";"));
}

}  // namespace
}  // namespace palpate::house
