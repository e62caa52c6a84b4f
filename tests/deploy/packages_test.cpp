// What deploy/package packs.  tests/deploy/try_packages installs and runs it.
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include <gmock/gmock.h>

#include "tests/house/source_tree.h"
#include "tests/support/read_file.h"

namespace palpate::house {
namespace {

using testing::HasSubstr;

std::string Read(const std::string& file) {
  return ReadWholeFile(PALPATE_SOURCE_DIR "/" + file);
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
  for (const char* file : {"deploy/observability", "deploy/security/identities"}) {
    EXPECT_THAT(rules, HasSubstr(std::string("${root}/") + file)) << file << " is not packed";
  }
}

/// A text with one space in place of each run of spaces and line ends.
std::string Flat(const std::string& text) {
  return std::regex_replace(text, std::regex(R"(\s+)"), " ");
}

TEST(Packages, AreDescribedInTheWordsOfTheirRules) {
  const std::string rules = Read("deploy/packages/CMakeLists.txt"),
                    made = Flat(ReadWholeFile(PALPATE_BIN_DIR "/../CPackConfig.cmake"));
  static const std::regex kText("\n +TEXT \"([^\"]+)\"");
  int with_semicolon = 0;
  for (std::sregex_iterator it(rules.begin(), rules.end(), kText), end; it != end; ++it) {
    const std::string text = Flat((*it)[1]);
    if (made.find("python3-palpate") == made.npos && text.find("NumPy") != text.npos) continue;
    EXPECT_THAT(made, HasSubstr(text));
    with_semicolon += text.find(';') != text.npos;
  }
  EXPECT_GE(with_semicolon, 2);
}

TEST(Packages, HaveAScriptForIdentitiesThatSaysItsVersionAsProgramsDo) {
  for (const char* script :
       {PALPATE_SOURCE_DIR "/deploy/security/identities", PALPATE_BIN_DIR "/palpate-identities"}) {
    const Output output = RunCommand({script, "--version"});
    EXPECT_EQ(output.exit_code, 0) << output.text;
    EXPECT_EQ(output.text, "palpate-identities " PALPATE_VERSION "\n");
  }
}

TEST(Packages, SayThatAPurgeLeavesTheUser) {
  const auto said = [](const char* action) {
    return RunCommand({"sh", "-c",
                       std::string("getent() { true; }; set -- ") + action + "; . " +
                           PALPATE_SOURCE_DIR "/deploy/packages/common/postrm"});
  };
  EXPECT_THAT(said("purge").text, HasSubstr("userdel palpate"));
  EXPECT_EQ(said("remove").text, "");
  EXPECT_EQ(said("remove").exit_code, 0);
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

TEST(Packages, HoldEveryPageThatOneOfThemLeadsTo) {
  const Output output = RunCommand({PALPATE_SOURCE_DIR "/deploy/packages/pages", "README.md"});
  ASSERT_EQ(output.exit_code, 0) << output.text;
  std::set<std::string> pages;
  std::istringstream lines(output.text);
  for (std::string line; std::getline(lines, line);) pages.insert(line);
  static const std::regex kLink(R"(\]\(([^)#:\s]+)(#[^)]*)?\))");
  for (const std::string& page : pages) {
    if (!page.ends_with(".md")) continue;
    const std::string text = Read(page);
    for (std::sregex_iterator it(text.begin(), text.end(), kLink), end; it != end; ++it) {
      const std::filesystem::path link = std::filesystem::path(page).parent_path() / (*it)[1].str();
      EXPECT_TRUE(pages.contains(link.lexically_normal())) << page << " leads to " << link;
    }
  }
  for (const char* page : {"deploy/lab.md", "deploy/README.md", "scenes/catalogue/README.md",
                           "tests/benchmarks/results/pareto.svg"}) {
    EXPECT_TRUE(pages.contains(page)) << page;
  }
  EXPECT_THAT(Read("deploy/packages/CMakeLists.txt"),
              HasSubstr("COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/pages README.md"));
  // The files that messages and units name.
  for (const auto& [file, page] :
       {std::pair("client/crtk/main.cpp", "client/crtk/README.md"),
        std::pair("deploy/systemd/palpate-roudi.service", "deploy/REALTIME.md"),
        std::pair("deploy/systemd/palpate-server.service", "deploy/REALTIME.md"),
        std::pair("deploy/systemd/palpate-.service.d/hardening.conf", "deploy/README.md")}) {
    EXPECT_TRUE(pages.contains(page)) << page;
    EXPECT_THAT(Read(file), HasSubstr(std::string("/usr/share/doc/palpate-common/") + page));
  }
}

}  // namespace
}  // namespace palpate::house
