// The program on this host, whatever it is, and the loop that it tries.
#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/doctor/loop_check.h"
#include "tests/support/program.h"
#include "tests/support/roudi.h"
#include "tests/support/test_domain.h"

namespace palpate::doctor {
namespace {

using testing::HasSubstr;
using testing::Not;

const int kDomain = test::OwnDomain();

std::vector<std::string> Arguments(std::vector<std::string> more) {
  more.insert(more.end(), {"--domain", std::to_string(kDomain)});
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
  EXPECT_EQ(CheckLoop(trial, dds::Transport::kSharedMemory).status, Status::kFault);
  roudi.Kill();
}

TEST(LoopTrial, ThatIsNotWhatItShouldBeIsAFault) {
  LoopTrial trial{.finished = true, .sent = 1000, .p50_us = 30.0, .p99_us = 90.0, .max_us = 200.0};
  EXPECT_EQ(CheckLoop(trial, dds::Transport::kUdp).status, Status::kOk);
  const Finding udp = CheckLoop(trial, dds::Transport::kSharedMemory);
  EXPECT_EQ(udp.status, Status::kFault);
  EXPECT_THAT(udp.found, HasSubstr("RouDi answers, and it is not used"));
  trial.p99_us = 700.0;
  EXPECT_EQ(CheckLoop(trial, dds::Transport::kUdp).status, Status::kWarning);
  trial.p99_us = 1200.0;
  EXPECT_EQ(CheckLoop(trial, dds::Transport::kUdp).status, Status::kFault);
  trial.p99_us = 90.0;
  trial.lost = 11;
  EXPECT_EQ(CheckLoop(trial, dds::Transport::kUdp).status, Status::kFault);
}

TEST(Doctor, ExitsWithItsVerdict) {
  test::Program doctor(PALPATE_BIN_DIR "/palpate-doctor",
                       Arguments({"--json", "--seconds", "0.2", "--transport", "udp"}));
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
  test::Program doctor(
      PALPATE_BIN_DIR "/palpate-doctor",
      Arguments({"--seconds", "0", "--transport", "udp", "--device", "openhaptics"}));
  EXPECT_EQ(doctor.Exit(60.0), 1);
  EXPECT_THAT(doctor.Output(), HasSubstr("verdict: not fit for 1 kHz"));
  EXPECT_THAT(doctor.Output(), HasSubstr("libHD.so"));
  EXPECT_THAT(doctor.Output(), Not(HasSubstr("\x1b"))) << "into a pipe, without colours";
}

TEST(Doctor, RefusesADeviceThatThereIsNot) {
  test::Program doctor(PALPATE_BIN_DIR "/palpate-doctor", {"--device", "crowbar"});
  EXPECT_EQ(doctor.Exit(), 2);
  EXPECT_THAT(doctor.Output(), HasSubstr("crowbar"));
}

TEST(Doctor, EndsOnCtrlCWithoutAVerdict) {
  test::Program doctor(PALPATE_BIN_DIR "/palpate-doctor",
                       Arguments({"--seconds", "3600", "--transport", "udp"}));
  ASSERT_TRUE(doctor.Says("  device  ", 60.0)) << doctor.Output();
  doctor.Signal(SIGINT);
  EXPECT_EQ(doctor.Exit(), 1);
  EXPECT_THAT(doctor.Output(), HasSubstr("stopped before a verdict"));
}

}  // namespace
}  // namespace palpate::doctor
