#include "common/program/command_line.h"

#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "common/error.h"
#include "common/revision.h"
#include "tests/support/complaint.h"

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A program with an option.
struct Program {
  Program() {
    app.Add("--rate", rate, "of something");
    AddNetworkOptions(app, "the other", network);
    AddRealtimeOptions(app, "the loop", realtime);
    AddCommonOptions(app, "which of them", domain, log_level);
  }
  bool Parse(std::vector<const char*> words) {
    words.insert(words.begin(), "/somewhere/bin/palpate-it");
    return ParseCommandLine(app, static_cast<int>(words.size()), words.data());
  }
  std::string Complaint(const std::vector<const char*>& words) {
    return test::ComplaintOf([&] { Parse(words); });
  }
  std::string Printed(const std::vector<const char*>& words) {
    testing::internal::CaptureStdout();
    EXPECT_FALSE(Parse(words));
    return testing::internal::GetCapturedStdout();
  }

  const CommandLine app{"It does nothing.", "palpate-it"};
  double rate = 1.0;
  bool flag = false;
  dds::Network network;
  RealtimeOptions realtime;
  int domain = 3;
  std::string log_level = "info";
};

TEST(CommandLine, NamesATypoWithTheNearestRightWord) {
  EXPECT_THAT(Program().Complaint({"--dommain", "3"}),
              HasSubstr("'--dommain' is not known; did you mean '--domain'?; 'palpate-it --help'"));
  EXPECT_THAT(Program().Complaint({"--log-levl=off"}), HasSubstr("did you mean '--log-level'?"));
  EXPECT_THAT(Program().Complaint({"--elephant"}),
              testing::StartsWith("'--elephant' is not known; 'palpate-it --help'"));
}

TEST(CommandLine, NamesATypoWhereTheRightWordIsMissing) {
  Program required;
  required.app.Find("--rate").Required();
  EXPECT_THAT(required.Complaint({"--rat", "2"}), HasSubstr("did you mean '--rate'?"));
  EXPECT_THAT(required.Complaint({}), HasSubstr("--rate is required"));

  Program commands;
  commands.app.RequireCommands(1, 1);
  commands.app.AddCommand("pareto", "").AddFlag("--scene", commands.flag, "");
  EXPECT_THAT(commands.Complaint({"paretto"}), HasSubstr("did you mean 'pareto'?"));
  EXPECT_THAT(commands.Complaint({"pareto", "--scen", "x"}), HasSubstr("did you mean '--scene'?"));
}

TEST(CommandLine, HasWhatEveryProgramHas) {
  Program program;
  EXPECT_TRUE(program.Parse({}));
  EXPECT_EQ(program.domain, 3);
  EXPECT_EQ(program.log_level, "info");
  EXPECT_TRUE(program.Parse({"--domain", "114", "--log-level", "off", "--rate", "2"}));
  EXPECT_EQ(program.domain, 114);
  EXPECT_EQ(program.log_level, "off");
  EXPECT_EQ(program.rate, 2.0);
  EXPECT_TRUE(program.Parse({"--log-format", "text"}));
  EXPECT_THAT(Program().Complaint({"--log-format", "xml"}), HasSubstr("give text or json"));
}

TEST(CommandLine, SaysWhereOthersAreAndHowALoopIsScheduled) {
  Program program;
  EXPECT_TRUE(program.Parse({}));
  EXPECT_TRUE(program.network.this_host());
  EXPECT_EQ(program.realtime.mode, RealtimeMode::kPrefer);
  EXPECT_EQ(program.realtime.cpu, -1);
  EXPECT_TRUE(program.Parse({"--network", "eth0", "--peer", "10.0.0.1", "--peer", "10.0.0.2",
                             "--realtime", "off", "--cpu", "3"}));
  EXPECT_EQ(program.network.interface, "eth0");
  EXPECT_THAT(program.network.peers, testing::ElementsAre("10.0.0.1", "10.0.0.2"));
  EXPECT_EQ(program.realtime.mode, RealtimeMode::kOff);
  EXPECT_EQ(program.realtime.cpu, 3);
  // Inside the program -1 means any core; on a command line it is a mistake.
  for (const char* cpu : {"-1", "-2", "1024", "all"}) {
    EXPECT_THAT(Program().Complaint({"--cpu", cpu}), HasSubstr("--cpu")) << cpu;
  }
  EXPECT_THAT(Program().Complaint({"--realtime", "perhaps"}),
              HasSubstr("give require, prefer or off"));
}

TEST(CommandLine, PrintsHelpAndVersionUnderTheProgramsName) {
  EXPECT_EQ(Program().Printed({"--version"}),
            std::string("palpate-it " PALPATE_VERSION "\nphysics ") + kPhysicsRevision +
                ", scenes " + kScenesRevision + "\n");
  const std::string help = Program().Printed({"--help"});
  for (const std::string word : {"It does nothing.", "which of them", "--domain", "--log-level"}) {
    EXPECT_THAT(help, HasSubstr(word));
  }
}

TEST(CommandLine, WrapsItsHelpTo80Columns) {
  Program program;
  program.app.AddCommand("score", "grades a trial\nby criteria that are told only in its own help");
  program.app.AddCommand("export",
                         "one line that is so long that it has to be continued on a second");
  const std::string help = program.Printed({"--help"});
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
  const std::string indent(30, ' ');
  EXPECT_THAT(help, HasSubstr("\n" + indent + "continued on a second\n"));
  EXPECT_THAT(help, HasSubstr("  score                       grades a trial\n"));
  EXPECT_THAT(help, Not(HasSubstr("by criteria")));
  EXPECT_THAT(program.Printed({"score", "--help"}), HasSubstr("by criteria"));
}

TEST(CommandLine, NamesTheArgumentThatIsWrongAndWhereToLook) {
  EXPECT_THAT(Program().Complaint({"--domain", "115"}), HasSubstr("--domain"));
  EXPECT_THAT(Program().Complaint({"--domain", "-1"}), HasSubstr("--domain"));
  EXPECT_THAT(Program().Complaint({"--no-such"}), HasSubstr("--no-such"));
  for (const char* rate : {"nan", "-nan", "inf", "1e999"}) {
    EXPECT_THAT(Program().Complaint({"--rate", rate}), HasSubstr("--rate")) << rate;
  }
  EXPECT_THAT(Program().Complaint({"--rate", "much"}),
              HasSubstr("; 'palpate-it --help' shows how"));
}

TEST(CommandLine, MakesAnExitStatusAndALineOfWhatAProgramThrows) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(RunProgram("palpate-it", [] { return 0; }), 0);
  EXPECT_EQ(RunProgram("palpate-it", [] { return 7; }), 7);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");

  testing::internal::CaptureStderr();
  EXPECT_EQ(RunProgram("palpate-it", []() -> int { throw Error("no server"); }), 1);
  EXPECT_EQ(RunProgram("palpate-it", []() -> int { throw std::bad_alloc(); }), 1);
  EXPECT_EQ(RunProgram("palpate-it", []() -> int { throw UsageError("--rate: no"); }), 2);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::AllOf(HasSubstr("palpate-it: no server\n"),
                             HasSubstr("palpate-it: out of memory; 'free' shows"),
                             HasSubstr("palpate-it: --rate: no\n")));
}

}  // namespace
}  // namespace palpate
