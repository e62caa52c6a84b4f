// End to end: a third-party driver in palpate-doctor, and in palpate-station at a palpate-server.
#include <csignal>
#include <filesystem>

#include <gmock/gmock.h>

#include "common/realtime/steady_clock.h"
#include "tests/link/silence.h"
#include "tests/support/eventually.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"
#include "tests/support/test_domain.h"

namespace palpate::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kDomain = std::to_string(OwnDomain());

Program Server() {
  return Program(PALPATE_BIN_DIR "/palpate-server", {"--scene", "cube", "--realtime", "off",
                                                     "--transport", "udp", "--domain", kDomain});
}

Program Station(const std::string& driver, const std::vector<std::string>& more) {
  return Program(
      PALPATE_BIN_DIR "/palpate-station",
      Joined({"--device", driver, "--scene", "cube", "--id", "arm", "--no-table", "--realtime",
              "off", "--transport", "udp", "--domain", kDomain, "--enable-forces"},
             more));
}

Program Doctor(const std::vector<std::string>& more) {
  return Program(PALPATE_BIN_DIR "/palpate-doctor",
                 Joined({"--seconds", "0", "--realtime", "off", "--transport", "udp", "--domain",
                         kDomain, "--device"},
                        more));
}

TEST(PluginStation, FeelsTheCubeWithAnArmOfOnesOwnAndLosesTheForceWithTheServer) {
  const Folder folder;
  const std::string trace = folder / "run.csv";
  Program server = Server();
  ASSERT_TRUE(server.Says("ready: ", 60.0)) << server.Output();
  Program station = Station(PALPATE_VIRTUAL_ARM, {"--trace", trace});
  ASSERT_TRUE(station.Says("session: tool", 60.0)) << station.Output();
  const auto eventually = [&](const auto& so) {
    return Eventually([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));  // a trace takes time to read
      server.Output();
      station.Output();
      // Nothing is written yet of a station that has just begun.
      std::error_code error;
      return std::filesystem::file_size(trace, error) > 0 && !error && so(ReadTrace(trace));
    });
  };
  // At its deepest, a hand of 0.4 N/mm is 4 mm deep in a cube of 1 N/mm: 1.1 N.
  ASSERT_TRUE(eventually([](const std::vector<TraceRow>& rows) {
    return !rows.empty() && rows.back().applied.force.y() > 0.7;
  })) << station.Output();
  const std::int64_t killed_ns = SteadyNanoseconds();
  server.Signal(SIGKILL);
  EXPECT_EQ(server.Exit(), -SIGKILL);
  ASSERT_TRUE(eventually([&](const std::vector<TraceRow>& rows) {
    return rows.back().time_ns > killed_ns + 500'000'000;
  }));
  station.Signal(SIGINT);
  EXPECT_EQ(station.Exit(), 0) << station.Output();
  EXPECT_THAT(station.Output(),
              AllOf(HasSubstr("device: virtual arm"), HasSubstr("the arm is ready"),
                    HasSubstr("this device renders no torque")));
  const std::vector<TraceRow> rows = ReadTrace(trace);
  const std::vector<double> silence_ms = CountedSilence_ms(rows);
  int silent = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].time_ns < killed_ns || silence_ms[i] < kForceGone_ms) continue;
    ++silent;
    ASSERT_TRUE(rows[i].applied.force.isZero(0.0)) << silence_ms[i] << " ms";
  }
  EXPECT_GT(silent, 100);
}

TEST(PluginStation, SaysWhichFunctionHangsAndStillEnds) {
  Program server = Server();
  ASSERT_TRUE(server.Says("ready: ", 60.0)) << server.Output();
  Program station = Station(PALPATE_WRONG_DRIVER, {"--device-name", "hangs"});
  EXPECT_TRUE(station.Says(
      "palpate_device_read did not return for 20 ms; palpate_device_stop turned the force off",
      60.0))
      << station.Output();
  station.Signal(SIGINT);
  EXPECT_EQ(station.Exit(), 0) << station.Output();
}

TEST(PluginStation, EndsWithOneAndTheReasonWhereTheFileIsNoDriver) {
  Program station = Station(PALPATE_NO_DRIVER, {});
  EXPECT_EQ(station.Exit(), 1);
  EXPECT_THAT(station.Output(), HasSubstr("build it as a shared object"));
}

TEST(Doctor, TriesADriverAndSeesThatItsHandleGivesWay) {
  Program doctor = Doctor({PALPATE_VIRTUAL_ARM, "--push"});
  doctor.Exit(120.0);  // as fit as the machine is
  EXPECT_THAT(
      doctor.Output(),
      AllOf(HasSubstr("virtual arm"), HasSubstr("5 N, continuously 1.5 N; 0 N m; workspace 200"),
            HasSubstr(" driver "), HasSubstr("ok       push"), HasSubstr("the handle moved")));
}

TEST(Doctor, FindsWhatADriverDoesWrong) {
  Program hangs = Doctor({PALPATE_WRONG_DRIVER, "--device-name", "hangs"});
  EXPECT_EQ(hangs.Exit(60.0), 1);
  EXPECT_THAT(hangs.Output(), HasSubstr("palpate_device_read did not return"));
  Program none = Doctor({PALPATE_DRIVER_WITHOUT_STOP});
  EXPECT_EQ(none.Exit(60.0), 1);
  EXPECT_THAT(none.Output(), AllOf(HasSubstr("has no palpate_device_stop"), HasSubstr("arm.md")));
  Program push = Doctor({"simulated", "--push"});
  EXPECT_EQ(push.Exit(60.0), 2);
  EXPECT_THAT(push.Output(), HasSubstr("--push needs a driver of your own"));
}

}  // namespace
}  // namespace palpate::test
