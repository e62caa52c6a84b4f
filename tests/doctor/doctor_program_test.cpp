// The program on this host, whatever it is like, and the loop that it tries.
#include <csignal>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "client/doctor/checks.h"
#include "tests/doctor/made_up_host.h"
#include "tests/support/program.h"
#include "tests/support/roudi.h"
#include "tests/support/test_domain.h"

namespace palpate::doctor {
namespace {

using testing::HasSubstr;
using testing::Not;

const int kDomain = test::OwnDomain();
constexpr const char* kDoctor = PALPATE_BIN_DIR "/palpate-doctor";

std::vector<std::string> Arguments(std::vector<std::string> more) {
  more.insert(more.end(), {"--transport", "udp", "--domain", std::to_string(kDomain)});
  return more;
}

TEST(LoopTrial, GoesThroughUdpAndComesBack) {
  StopSignal stop;
  const LoopTrial trial = TryLoop({.domain = kDomain, .transport = dds::Transport::kUdp}, stop);
  ASSERT_TRUE(trial.finished) << trial.error;
  EXPECT_FALSE(trial.shared_memory);
  EXPECT_EQ(trial.sent, 1000u);
  EXPECT_GT(trial.p50_us, 0.0);
  EXPECT_LE(trial.p50_us, trial.max_us);
}

TEST(LoopTrial, IsReallySharedMemoryWhereRouDiRuns) {
  RouDi roudi;
  StopSignal stop;
  const LoopTrial trial =
      TryLoop({.domain = kDomain, .transport = dds::Transport::kSharedMemory}, stop);
  ASSERT_TRUE(trial.finished) << trial.error;
  EXPECT_TRUE(trial.shared_memory);
  EXPECT_LT(trial.lost, trial.sent);
}

TEST(LoopTrial, OutlivesARouDiThatHangs) {
  RouDi roudi;
  roudi.Hang();
  StopSignal stop;
  const LoopTrial trial =
      TryLoop({.domain = kDomain, .transport = dds::Transport::kSharedMemory}, stop);
  EXPECT_FALSE(trial.finished);
  EXPECT_THAT(CheckLoop(trial, dds::Transport::kSharedMemory), IsFault());
  roudi.Kill();
}

TEST(LoopTrial, ThatIsNotWhatItShouldBeIsAFault) {
  LoopTrial trial{.finished = true, .sent = 1000, .p50_us = 30.0, .p99_us = 90.0, .max_us = 200.0};
  EXPECT_THAT(CheckLoop(trial, dds::Transport::kUdp), IsOk());
  EXPECT_THAT(CheckLoop(trial, dds::Transport::kSharedMemory),
              IsFault("RouDi answers but is not used"));
  trial.p99_us = 700.0;
  EXPECT_THAT(CheckLoop(trial, dds::Transport::kUdp), IsWarning());
  trial.p99_us = 1200.0;
  EXPECT_THAT(CheckLoop(trial, dds::Transport::kUdp), IsFault());
  trial.p99_us = 90.0;
  trial.lost = 11;
  EXPECT_THAT(CheckLoop(trial, dds::Transport::kUdp), IsFault());
}

TEST(Doctor, ExitsWithItsVerdict) {
  test::Program doctor(kDoctor, Arguments({"--json", "--seconds", "0.2"}));
  const int status = doctor.Exit(60.0);
  const auto json = nlohmann::json::parse(doctor.Output());
  EXPECT_GE(json["findings"].size(), 16u);
  EXPECT_EQ(status, json["verdict"] == "not fit" ? 1 : 0);
  for (const auto& finding : json["findings"]) {
    EXPECT_NE(finding["found"], "") << finding;
    EXPECT_EQ(finding["status"] == "ok", finding["remedy"] == "") << finding;
  }
}

TEST(Doctor, IsNotFitForADeviceThatIsNotReady) {
  test::Program doctor(kDoctor, Arguments({"--seconds", "0", "--device", "openhaptics"}));
  EXPECT_EQ(doctor.Exit(60.0), 1);
  EXPECT_THAT(doctor.Output(), HasSubstr("verdict: not fit for 1 kHz"));
  EXPECT_THAT(doctor.Output(), HasSubstr("libHD.so"));
  EXPECT_THAT(doctor.Output(), Not(HasSubstr("\x1b"))) << "into a pipe, without colours";
}

TEST(Doctor, RefusesADeviceThatThereIsNot) {
  test::Program doctor(kDoctor, {"--device", "crowbar"});
  EXPECT_EQ(doctor.Exit(), 2);
  EXPECT_THAT(doctor.Output(), HasSubstr("crowbar"));
}

TEST(Doctor, EndsOnCtrlCWithoutAVerdict) {
  test::Program doctor(kDoctor, Arguments({"--seconds", "3600"}));
  ASSERT_TRUE(doctor.Says("  device  ", 60.0)) << doctor.Output();
  doctor.Signal(SIGINT);
  EXPECT_EQ(doctor.Exit(), 1);
  EXPECT_THAT(doctor.Output(), HasSubstr("stopped before a verdict"));
}

}  // namespace
}  // namespace palpate::doctor
