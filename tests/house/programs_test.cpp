#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/house/source_tree.h"

// What users may expect of every program and script.
namespace palpate::house {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// The programs of the build, as CMake lists them, e.g. "palpate-server,palpate-station".
std::vector<std::string> Programs() {
  std::vector<std::string> programs;
  std::string rest = PALPATE_PROGRAMS;
  while (!rest.empty()) {
    const std::size_t end = rest.find(',');
    programs.push_back(rest.substr(0, end));
    rest = end == std::string::npos ? "" : rest.substr(end + 1);
  }
  return programs;
}

std::string PathOf(const std::string& program) {
  return std::string(PALPATE_BIN_DIR) + "/" + program;
}

TEST(Programs, AreBuiltUnderTheProjectsName) {
  EXPECT_FALSE(Programs().empty());
  for (const std::string& program : Programs()) EXPECT_THAT(program, HasSubstr("palpate-"));
}

/// The commands listed by a help, found by CLI11's two columns.
std::vector<std::string> CommandsOf(const std::string& help) {
  std::vector<std::string> commands;
  std::istringstream lines(help.substr(std::min(help.find("Subcommands:"), help.size())));
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line) && !line.empty()) {
    // Lines that continue the one above are indented further.
    if (line.starts_with("  ") && line[2] != ' ')
      commands.push_back(line.substr(2, line.find(' ', 2) - 2));
  }
  return commands;
}

/// The part of a help from its examples to its end.
std::string ExamplesOf(const std::string& help) {
  return help.substr(std::min(help.rfind("\nExample"), help.size()));
}

/// The lines of a text that are wider than a terminal.
std::vector<std::string> WideLines(const std::string& text) {
  constexpr int kColumns = 80;
  std::vector<std::string> wide;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    // Bytes that continue a character of UTF-8 take no column.
    if (std::ranges::count_if(line, [](char c) { return (c & 0xc0) != 0x80; }) > kColumns) {
      wide.push_back(line);
    }
  }
  return wide;
}

TEST(Programs, TeachWithHelpThatHasAnExampleForEachCommandAndFitsATerminal) {
  int commands = 0;
  for (const std::string& program : Programs()) {
    const Output help = RunCommand({PathOf(program), "--help"});
    EXPECT_EQ(help.exit_code, 0) << program;
    for (const std::string word : {"--help", "--version", "--domain", "--log-level"}) {
      EXPECT_THAT(help.text, HasSubstr(word)) << program;
    }
    EXPECT_THAT(help.text, HasSubstr("xample")) << program;
    EXPECT_THAT(help.text, HasSubstr(program)) << program << ": the example names no program";
    EXPECT_THAT(help.text, Not(HasSubstr(PALPATE_SOURCE_DIR))) << "a place of this machine";
    EXPECT_THAT(WideLines(help.text), IsEmpty()) << program;
    for (const std::string& command : CommandsOf(help.text)) {
      const Output own = RunCommand({PathOf(program), command, "--help"});
      EXPECT_EQ(own.exit_code, 0) << program << ' ' << command;
      EXPECT_THAT(ExamplesOf(own.text), HasSubstr(program + " " + command)) << own.text;
      EXPECT_NE(ExamplesOf(own.text), ExamplesOf(help.text)) << program << ' ' << command;
      EXPECT_THAT(WideLines(own.text), IsEmpty()) << program << ' ' << command;
      ++commands;
    }
  }
  EXPECT_GE(commands, 11);  // of scene, replay, record and lesson; the benchmarks may be left out
}

TEST(Programs, TellTheirVersion) {
  for (const std::string& program : Programs()) {
    const Output version = RunCommand({PathOf(program), "--version"});
    EXPECT_EQ(version.exit_code, 0) << program;
    EXPECT_THAT(version.text, HasSubstr(PALPATE_VERSION)) << program;
  }
}

TEST(Programs, EndWithTwoWhereTheCommandLineIsWrong) {
  for (const std::string& program : Programs()) {
    const Output output = RunCommand({PathOf(program), "--no-such-option"});
    EXPECT_EQ(output.exit_code, 2) << program << ": " << output.text;
    EXPECT_THAT(output.text, HasSubstr("--help")) << program << ": says not where to look";
  }
}

TEST(Scripts, TeachAndRefuseLikeThePrograms) {
  for (const std::string script :
       {"deploy/demo", "deploy/setup", "deploy/package", "deploy/wheel", "deploy/container/run",
        "tests/run", "tests/deploy/try_packages", "tests/deploy/try_containers",
        "tests/deploy/try_pod", "tests/deploy/try_services", "tests/benchmarks/capacity_model",
        "tests/benchmarks/publish"}) {
    const std::string path = std::string(PALPATE_SOURCE_DIR) + "/" + script;
    const Output help = RunCommand({path, "--help"});
    EXPECT_EQ(help.exit_code, 0) << script;
    EXPECT_THAT(help.text, HasSubstr("usage: " + script)) << script;
    EXPECT_THAT(WideLines(help.text), IsEmpty()) << script;
    const Output wrong = RunCommand({path, "--no-such-option"});
    EXPECT_EQ(wrong.exit_code, 2) << script;
    EXPECT_THAT(wrong.text, HasSubstr("no-such-option")) << script;
  }
}

}  // namespace
}  // namespace palpate::house
