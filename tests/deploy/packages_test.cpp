// What deploy/package packs.  tests/deploy/try_packages installs and runs it.
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/house/source_tree.h"

namespace palpate::house {
namespace {

using testing::HasSubstr;

std::string Read(const std::string& file) {
  return ReadFile(PALPATE_SOURCE_DIR "/" + file);
}

/// The words between "palpate_package(" and its ")".
std::map<std::string, int> PackedPrograms() {
  std::map<std::string, int> packed;
  const std::string text = Read("deploy/packages/CMakeLists.txt");
  for (const std::string call : {"\npalpate_package(", "\n  palpate_package("}) {
    for (std::size_t at = text.find(call); at != std::string::npos; at = text.find(call, at + 1)) {
      const std::size_t end = text.find(')', at);
      std::istringstream words(text.substr(at + call.size(), end - at - call.size()));
      for (std::string word; words >> word;) {
        if (word.starts_with("palpate-")) ++packed[word];
      }
    }
  }
  return packed;
}

TEST(Packages, HoldEachProgramOnce) {
  std::map<std::string, int> built;
  std::istringstream programs(PALPATE_PROGRAMS);
  for (std::string program; std::getline(programs, program, ',');) built[program] = 1;
  EXPECT_EQ(PackedPrograms(), built)
      << "enter a new program in deploy/packages/CMakeLists.txt, in the package of its users";
}

TEST(Packages, HoldTheUnitsAndWhatTheUnitsRead) {
  const std::string rules = Read("deploy/packages/CMakeLists.txt");
  for (const std::string& file : SourceFiles(PALPATE_SOURCE_DIR)) {
    if (!file.starts_with("deploy/systemd/")) continue;
    EXPECT_THAT(rules, HasSubstr(file.substr(file.rfind('/') + 1))) << file << " is not packed";
  }
}

TEST(Packages, HoldWhatALabReadsAndWhatTheProgramsTellItToCall) {
  const std::string rules = Read("deploy/packages/CMakeLists.txt");
  for (const char* file : {"deploy/README.md", "deploy/REALTIME.md", "deploy/SECURITY.md",
                           "deploy/observability", "deploy/security/identities"}) {
    EXPECT_THAT(rules, HasSubstr(std::string("${root}/") + file)) << file << " is not packed";
  }
}

TEST(Packages, HaveAManualWithEachCommandOfAProgram) {
  if (RunCommand({"sh", "-c", "command -v help2man"}).exit_code != 0) {
    GTEST_SKIP() << "help2man is missing: deploy/setup --for packages installs it";
  }
  const std::string program = testing::TempDir() + "palpate-made-up", page = program + ".1.gz";
  std::ofstream(program) << R"(#!/bin/sh
case $1 in
  score) printf 'Scores.\nUsage: palpate-made-up score [OPTIONS]\n\n.dot and \\ of score\n' ;;
  *) printf 'Does much.\n\nUsage: palpate-made-up [SUBCOMMAND]\n\nSubcommands:\n  score    scores\n           well\n\nExamples:\n  made\n' ;;
esac
)";
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  const Output made = RunCommand({"sh", PALPATE_SOURCE_DIR "/deploy/packages/manual.sh", program,
                                  page, "does much", "palpate-made-up 1"});
  EXPECT_EQ(made.exit_code, 0) << made.text;
  const std::string text = RunCommand({"gzip", "-dc", page}).text;
  EXPECT_THAT(text, HasSubstr(".SH \"COMMAND SCORE\""));
  EXPECT_THAT(text, HasSubstr("palpate\\-made\\-up score [OPTIONS]"));
  EXPECT_THAT(text, HasSubstr("\\&.dot and \\e of score"));
  for (const std::string& file : {program, page}) std::filesystem::remove(file);
}

TEST(Packages, HoldThePagesThatMessagesName) {
  const std::string rules = Read("deploy/packages/CMakeLists.txt");
  for (const char* page :
       {"${root}/client/crtk/README.md DESTINATION share/doc/palpate-common RENAME CRTK.md",
        "devices devices/openhaptics devices/forcedimension devices/haply",
        "share/doc/palpate-common/${folder} ${root}/${folder}/README.md"}) {
    EXPECT_THAT(rules, HasSubstr(page));
  }
  EXPECT_THAT(Read("client/crtk/options.cpp"), HasSubstr("/usr/share/doc/palpate-common/CRTK.md"));
}

}  // namespace
}  // namespace palpate::house
