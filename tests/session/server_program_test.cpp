// palpate-server as a person meets it: what it says and how it exits.
#include <csignal>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/dds/participant.h"
#include "common/server_lock.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const int kDomain = 40 + getpid() % 60;

/// A run of palpate-server whose output can be read.
class Program {
 public:
  explicit Program(std::vector<std::string> arguments, bool without_rights = false) {
    arguments.insert(arguments.begin(), "palpate-server");
    if (arguments.size() > 1 && arguments[1] != "--help" && arguments[1] != "--version") {
      arguments.insert(arguments.end(), {"--domain", std::to_string(kDomain)});
    }
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("no pipe");
    pid_ = fork();
    if (pid_ == 0) {
      dup2(ends[1], STDOUT_FILENO);
      dup2(ends[1], STDERR_FILENO);
      close(ends[0]);
      close(ends[1]);
      // Not as another user, who might not be allowed to read the build folder.
      const rlimit none{0, 0};
      if (without_rights && (prctl(PR_CAPBSET_DROP, CAP_SYS_NICE, 0, 0, 0) != 0 ||
                             setrlimit(RLIMIT_RTPRIO, &none) != 0)) {
        _exit(126);
      }
      std::vector<char*> argv;
      for (std::string& argument : arguments) argv.push_back(argument.data());
      argv.push_back(nullptr);
      execv(PALPATE_BIN_DIR "/palpate-server", argv.data());
      _exit(127);
    }
    close(ends[1]);
    output_ = fdopen(ends[0], "r");
  }
  ~Program() {
    if (pid_ > 0) Stop(SIGKILL);
    fclose(output_);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  std::string Line() {
    std::string line;
    for (int c = fgetc(output_); c != EOF && c != '\n'; c = fgetc(output_)) {
      line += static_cast<char>(c);
    }
    return line;
  }
  /// The rest of what it says.
  std::string Rest() {
    std::string text;
    for (int c = fgetc(output_); c != EOF; c = fgetc(output_)) text += static_cast<char>(c);
    return text;
  }
  int Exit() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  int Stop(int signal) {
    kill(pid_, signal);
    return Exit();
  }

 private:
  pid_t pid_ = -1;
  FILE* output_ = nullptr;
};

TEST(ServerProgram, TeachesItselfWithAnExample) {
  Program program({"--help"});
  EXPECT_THAT(program.Rest(), HasSubstr("Example: palpate-server --scene"));
  EXPECT_EQ(program.Exit(), 0);
}

TEST(ServerProgram, TellsItsVersion) {
  Program program({"--version"});
  EXPECT_EQ(program.Line(), PALPATE_VERSION);
  EXPECT_EQ(program.Exit(), 0);
}

TEST(ServerProgram, IsReadyAndStopsOnASignal) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Program program({"--scene", "cube", "--transport", "udp"});
    const std::string line = program.Line();
    EXPECT_THAT(line, StartsWith("ready"));
    EXPECT_THAT(line, HasSubstr("scenes cube"));
    EXPECT_THAT(line, HasSubstr("UDP (as asked)"));
    EXPECT_THAT(line, HasSubstr("real-time "));
    EXPECT_EQ(program.Stop(signal), 0);
  }
}

TEST(ServerProgram, RefusesADomainInUse) {
  const ServerLock lock(kDomain);
  Program program({"--scene", "cube", "--transport", "udp"});
  EXPECT_THAT(program.Rest(), HasSubstr("is in use by another palpate-server (pid " +
                                        std::to_string(getpid()) + "); stop that one"));
  EXPECT_EQ(program.Exit(), 1);
}

TEST(ServerProgram, NamesTheScenesThatThereAreWhereOneIsUnknown) {
  Program program({"--scene", "no-such-scene", "--transport", "udp"});
  const std::string text = program.Rest();
  EXPECT_THAT(text, HasSubstr("no-such-scene"));
  EXPECT_THAT(text, HasSubstr("bunny-bunny"));
  EXPECT_EQ(program.Exit(), 1);
}

TEST(ServerProgram, RefusesSharedMemoryWithoutRouDiAndSaysHowToStartIt) {
  if (dds::RouDiAnswers()) GTEST_SKIP() << "RouDi runs on this machine";
  Program program({"--scene", "cube", "--transport", "shm"});
  EXPECT_THAT(program.Rest(), HasSubstr("no RouDi listens at /tmp/roudi; start it with"));
  EXPECT_EQ(program.Exit(), 1);
}

TEST(ServerProgram, RefusesRequiredRealTimeWithoutTheRightAndNamesTheLimit) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, to give rights up";
  Program program({"--scene", "cube", "--transport", "udp", "--realtime", "require"}, true);
  const std::string text = program.Rest();
  EXPECT_THAT(text, HasSubstr("ulimit -r is 0"));
  EXPECT_THAT(text, HasSubstr("limits.d"));
  EXPECT_EQ(program.Exit(), 1);
}

class ServerProgramUsage : public testing::TestWithParam<std::vector<std::string>> {};

TEST_P(ServerProgramUsage, ExitsWithTwoWhereTheCommandLineIsWrong) {
  Program program(GetParam());
  EXPECT_FALSE(program.Rest().empty());
  EXPECT_EQ(program.Exit(), 2);
}

INSTANTIATE_TEST_SUITE_P(
    Wrong, ServerProgramUsage,
    testing::Values(
        std::vector<std::string>{"--transport", "udp"},
        std::vector<std::string>{"--scene", "cube", "--transport", "tcp"},
        std::vector<std::string>{"--scene", "cube", "--transport", "udp", "--realtime", "maybe"},
        std::vector<std::string>{"--scene", "cube", "--transport", "udp", "--cpu", "4096"},
        std::vector<std::string>{"--scene", "cube", "--cpu", "-2"},
        std::vector<std::string>{"--scene", "cube", "--log-level", "loud"},
        std::vector<std::string>{"--scene", "cube", "--domain", "1000"},
        std::vector<std::string>{"--scene", "cube", "--nonsense"}));

}  // namespace
}  // namespace palpate::test
