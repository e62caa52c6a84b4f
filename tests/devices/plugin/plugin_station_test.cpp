// End to end: a third-party driver in palpate-doctor, and in palpate-station at a palpate-server.
#include <csignal>
#include <cstdio>
#include <filesystem>

#include <gmock/gmock.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/realtime/steady_clock.h"
#include "tests/link/silence.h"
#include "tests/support/eventually.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"
#include "tests/support/stall_witness.h"
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

const std::string kStation = PALPATE_BIN_DIR "/palpate-station";
std::vector<std::string> StationWords(const std::string& driver) {
  return {"--device",   driver, "--scene",     "cube", "--id",     "arm",   "--no-table",
          "--realtime", "off",  "--transport", "udp",  "--domain", kDomain, "--enable-forces"};
}
Program Station(const std::string& driver, const std::vector<std::string>& more) {
  return Program(kStation, Joined(StationWords(driver), more));
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

/// An arm that presses on the cube, and notes each call in a file.
class PressedArm : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(server_.Says("ready: ", 60.0)) << server_.Output(); }
  std::vector<std::string> Arm() {
    std::filesystem::remove(calls_);
    return {"--device-name", "presses " + calls_};
  }
  std::string Calls() const { return std::filesystem::exists(calls_) ? ReadWholeFile(calls_) : ""; }
  bool Presses() {
    return Eventually([&] { return Calls().ends_with("force\n"); }, 30.0);
  }
  /// Whether the last that the arm heard was to stop, and then to close.
  bool WasReleased() const { return Calls().ends_with("stop\nclose\n"); }

 private:
  Program server_ = Server();
  const Folder folder_;
  const std::string calls_ = folder_ / "calls";
};

TEST_F(PressedArm, IsReleasedByEachSignalThatEndsTheStation) {
  for (const int signal : {SIGHUP, SIGINT, SIGQUIT, SIGTERM}) {
    Program station = Station(PALPATE_WRONG_DRIVER, Arm());
    ASSERT_TRUE(Presses()) << station.Output();
    station.Signal(signal);
    EXPECT_EQ(station.Exit(), 0) << signal << station.Output();
    EXPECT_TRUE(WasReleased()) << signal << Calls();
  }
}

TEST_F(PressedArm, IsReleasedWhereTheStationsTerminalIsClosed) {
  std::vector<std::string> words =
      Joined(Joined({kStation}, StationWords(PALPATE_WRONG_DRIVER)), Arm());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  int terminal = -1;
  const pid_t station = forkpty(&terminal, nullptr, nullptr, nullptr);
  if (station == 0) {
    execv(argv[0], argv.data());
    _exit(127);
  }
  EXPECT_TRUE(Presses());
  close(terminal);  // its output fails from here on
  int status = 0;
  ASSERT_TRUE(Eventually([&] { return waitpid(station, &status, WNOHANG) == station; }, 20.0));
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_TRUE(WasReleased()) << Calls();
}

TEST_F(PressedArm, IsReleasedWhereNobodyReadsTheStationsOutput) {
  Program station = Station(PALPATE_WRONG_DRIVER, Arm());
  ASSERT_TRUE(Presses()) << station.Output();
  station.CloseOutput();
  EXPECT_EQ(station.Exit(), 0);
  EXPECT_TRUE(WasReleased()) << Calls();
}

TEST_F(PressedArm, KeepsItsLoopWhereCtrlZWouldSuspendIt) {
  Program station = Station(PALPATE_WRONG_DRIVER, Arm());
  ASSERT_TRUE(Presses()) << station.Output();
  station.Signal(SIGTSTP);
  station.Signal(SIGTERM);
  EXPECT_EQ(station.Exit(), 0) << station.Output();
  EXPECT_TRUE(WasReleased()) << Calls();
}

TEST_F(PressedArm, IsReleasedByEachSignalThatEndsTheDoctor) {
  for (const int signal : {SIGHUP, SIGINT, SIGQUIT, SIGTERM}) {
    Program doctor = Doctor(Joined({PALPATE_WRONG_DRIVER, "--push"}, Arm()));
    ASSERT_TRUE(Presses()) << doctor.Output();
    doctor.Signal(signal);
    EXPECT_EQ(doctor.Exit(), 1) << signal << doctor.Output();
    EXPECT_TRUE(WasReleased()) << signal << Calls();
  }
}

TEST(PluginStation, SaysOnceThatAMotorTemperatureIsOutOfItsRange) {
  Program server = Server();
  ASSERT_TRUE(server.Says("ready: ", 60.0)) << server.Output();
  Program station = Station(PALPATE_WRONG_DRIVER, {"--device-name", "hot", "--for", "2.5"});
  EXPECT_EQ(station.Exit(), 0);
  const std::string& said = station.Output();
  const std::size_t first = said.find("motor temperature above 1");
  ASSERT_NE(first, std::string::npos) << said;
  EXPECT_EQ(said.find("motor temperature above 1", first + 1), std::string::npos) << said;
  Program doctor = Doctor({PALPATE_WRONG_DRIVER, "--device-name", "hot"});
  doctor.Exit(60.0);
  EXPECT_THAT(doctor.Output(), HasSubstr("motor temperature above 1"));
}

TEST(PluginStation, NamesTheFunctionThatSlowsTheLoopAsAWarning) {
  Program server = Server();
  ASSERT_TRUE(server.Says("ready: ", 60.0)) << server.Output();
  Program station = Station(PALPATE_WRONG_DRIVER, {"--device-name", "slow", "--for", "3"});
  EXPECT_TRUE(station.Says("warning: device: ", 60.0));
  EXPECT_TRUE(station.Says("palpate_device_read takes", 2.0));
  EXPECT_EQ(station.Exit(), 0);
  EXPECT_THAT(station.Output(), AllOf(HasSubstr("the loop is slow"),
                                      testing::Not(HasSubstr("late or missing replies"))));
}

TEST(PluginStation, EndsWithOneAndTheReasonWhereTheFileIsNoDriver) {
  Program station = Station(PALPATE_NO_DRIVER, {});
  EXPECT_EQ(station.Exit(), 1);
  EXPECT_THAT(station.Output(), HasSubstr("build it as a shared object"));
}

/// Whether the doctor says this of a driver.  Spoilt where the machine held its loop up, which it
/// says in place of what it would have found.
testing::AssertionResult Finds(const std::vector<std::string>& words,
                               const testing::Matcher<std::string>& finding) {
  return Shown([&](StallWitness& witness) {
    Program doctor = Doctor(words);
    witness.Watch(doctor.id());
    doctor.Exit(120.0);  // as fit as the machine is
    if (finding.Matches(doctor.Output())) return Attempt::kShown;
    std::printf("%s", doctor.Output().c_str());
    const auto tells = [&](const char* text) {
      return doctor.Output().find(text) != std::string::npos;
    };
    const bool slow = tells("the loop was held up") || tells("the loop makes ");
    return slow ? Attempt::kSpoilt : Attempt::kFailed;
  });
}

TEST(Doctor, TriesADriverAndSeesThatItsHandleGivesWay) {
  EXPECT_TRUE(Finds(
      {PALPATE_VIRTUAL_ARM, "--push"},
      AllOf(HasSubstr("virtual arm"), HasSubstr("5 N, continuously 1.5 N; 0 N m; workspace 200"),
            HasSubstr(" driver "), HasSubstr("ok       push"), HasSubstr("the handle moved"))));
}

TEST(Doctor, TakesNoDriverForFitThatIsSlowOrExchangesAxes) {
  for (const auto& [name, finding] :
       {std::pair{"slow", "fault    driver"}, std::pair{"exchanges", "fault    push"}}) {
    EXPECT_TRUE(Finds({PALPATE_WRONG_DRIVER, "--device-name", name, "--push"},
                      AllOf(HasSubstr(finding), HasSubstr("verdict: not fit"))))
        << name;
  }
}

TEST(Doctor, NamesTheFunctionInWhichADriverCrashesAndStillGivesItsVerdict) {
  for (const std::string function : {"open", "read", "write", "stop", "close"}) {
    Program doctor = Doctor({PALPATE_WRONG_DRIVER, "--device-name", "crashes " + function});
    EXPECT_EQ(doctor.Exit(60.0), 1) << function;
    EXPECT_THAT(doctor.Output(), AllOf(HasSubstr("palpate_device_" + function + " crashed"),
                                       HasSubstr("verdict: not fit")));
  }
}

TEST(Doctor, FindsWhatADriverDoesWrong) {
  EXPECT_TRUE(
      Finds({PALPATE_WRONG_DRIVER, "--device-name", "hangs"},
            AllOf(HasSubstr("fault    driver"), HasSubstr("palpate_device_read did not return"))));
  Program none = Doctor({PALPATE_DRIVER_WITHOUT_STOP});
  EXPECT_EQ(none.Exit(60.0), 1);
  EXPECT_THAT(none.Output(), AllOf(HasSubstr("has no palpate_device_stop"), HasSubstr("arm.md")));
  Program push = Doctor({"simulated", "--push"});
  EXPECT_EQ(push.Exit(60.0), 2);
  EXPECT_THAT(push.Output(), HasSubstr("--push needs a driver of your own"));
}

}  // namespace
}  // namespace palpate::test
