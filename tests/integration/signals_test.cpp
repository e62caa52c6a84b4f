// Every program that runs until it is told to end, and every signal that tells it.
#include <csignal>
#include <deque>
#include <filesystem>

#include <gtest/gtest.h>

#include "client/recorder/file_summary.h"
#include "tests/integration/rig.h"
#include "tests/support/folder.h"

namespace palpate::test {
namespace {

constexpr int kSignals[] = {SIGHUP, SIGINT, SIGQUIT, SIGTERM};

/// A program that runs, and the exit status with which it is to end.
struct Running {
  std::string name;
  int ends_with;
  Program program;

  Running(const std::string& what, std::vector<std::string> words, int ends = 0,
          int domain = kDomain)
      : name(what),
        ends_with(ends),
        program(PALPATE_BIN_DIR "/" + what,
                Joined(std::move(words), {"--domain", std::to_string(domain)})) {}
};

class EndingSignal : public testing::TestWithParam<int> {};

TEST_P(EndingSignal, EndsEveryProgramInOrderAndLeavesAWholeRecording) {
  const Folder folder;
  const std::string file = folder / "run.mcap";
  std::deque<Running> all;
  all.emplace_back("palpate-server", std::vector<std::string>{"cube", "--transport", "udp"});
  ASSERT_TRUE(all.front().program.Says("ready: ", 60.0)) << all.front().program.Output();
  all.emplace_back("palpate-record", std::vector<std::string>{"-o", file, "--transport", "udp"});
  ASSERT_TRUE(all.back().program.Says("recording to ", 60.0)) << all.back().program.Output();
  const std::string port = "0";
  all.emplace_back("palpate-igtl", std::vector<std::string>{"--port", port});
  all.emplace_back("palpate-crtk", std::vector<std::string>{"--transport", "udp"});
  all.emplace_back("palpate-load", std::vector<std::string>{"--stations", "1", "--seconds", "60"});
  all.emplace_back("palpate-doctor", std::vector<std::string>{"--transport", "udp"}, 1);
  all.emplace_back(
      "palpate-replay",
      std::vector<std::string>{PALPATE_SOURCE_DIR "/tests/replayer/golden/cube.mcap", "--loop"}, 0,
      kDomain + 1);
  // A hang-up has the gateway read its files again.
  if (GetParam() != SIGHUP) {
    all.emplace_back("palpate-viewer", std::vector<std::string>{"--http", port});
  }
  for (Running& one : all) {
    EXPECT_TRUE(Eventually([&] { return one.program.Handles(GetParam()) || !one.program.Runs(); }))
        << one.name;
    one.program.Signal(GetParam());
  }
  for (Running& one : all) {
    EXPECT_EQ(one.program.Exit(), one.ends_with) << one.name << one.program.Output();
  }
  EXPECT_TRUE(Summarise({file}).intact()) << ToText(Summarise({file}));
}

INSTANTIATE_TEST_SUITE_P(Each, EndingSignal, testing::ValuesIn(kSignals),
                         [](const auto& info) { return std::string(sigabbrev_np(info.param)); });

}  // namespace
}  // namespace palpate::test
