// Tests the reports of tests/benchmarks/publish to which tests/benchmarks/results/README.md links.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/benchmarks/bench_fixture.h"
#include "tests/support/program.h"

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

const std::string kScript = PALPATE_SOURCE_DIR "/tests/benchmarks/publish";
const std::vector<std::string> kReports = {"pareto", "accuracy", "stability", "qp", "peers"};

class Publish : public test::PalpateBench {
 protected:
  /// Runs it to its end with this build's palpate-bench; fills in said_ with its output.
  int Run(std::vector<std::string> arguments) {
    const std::string preset = fs::path(PALPATE_BIN_DIR).parent_path().filename();
    arguments.insert(arguments.end(), {"--no-build", "--preset", preset});
    test::Program program(kScript, std::move(arguments));
    const int status = program.Exit(100.0);
    said_ = program.Output();
    return status;
  }
};

/// Returns the cells of each row of a Markdown table; separate tables follow each other.
std::vector<std::vector<std::string>> TableRows(const std::string& markdown) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(markdown);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("|")) continue;
    std::vector<std::string> cells;
    for (std::size_t from = 1, to = 0; (to = line.find('|', from)) != std::string::npos;) {
      cells.push_back(line.substr(from, to - from));
      from = to + 1;
    }
    rows.push_back(cells);
  }
  return rows;
}

TEST_F(Publish, WritesEachReportWithItsFiguresAndWhatTheyWereMeasuredOn) {
  ASSERT_EQ(Run({"--smoke", "--out", folder_.path()}), 0) << said_;
  for (const std::string& name : kReports) {
    SCOPED_TRACE(name);
    const std::string report = Read(name + ".md");
    EXPECT_TRUE(report.starts_with("# "));
    EXPECT_THAT(report, HasSubstr("\ntests/benchmarks/publish --only " + name + " --smoke"));
    EXPECT_THAT(report, HasSubstr("\npalpate-bench " + name + " "));
    EXPECT_THAT(report, HasSubstr("**A smoke run:**"));
    EXPECT_THAT(report, Not(HasSubstr(PALPATE_SOURCE_DIR "/"))) << "a path of this machine";
    for (const char* what :
         {R"(\| processor \| \S)", R"(\| cores \| [0-9]+ \|)", R"(\| compiler \| \S)",
          R"(\| build \| preset \S+, \S)", R"(\| begun \| 20\d\d-\d\d-\d\d \d\d:\d\d UTC \|)",
          R"(\| load averages before \| [0-9.]+ [0-9.]+ [0-9.]+ \|)"}) {
      EXPECT_TRUE(std::regex_search(report, std::regex(what))) << what;
    }
    // Every row of figures is as long as its header.
    std::size_t figures = 0, columns = 0;
    const auto rows = TableRows(report);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const bool head = i + 1 < rows.size() && rows[i + 1][0].find("---") != std::string::npos;
      if (head) columns = rows[i].size();
      EXPECT_EQ(rows[i].size(), columns) << "row " << i;
      if (columns <= 2) continue;
      for (const std::string& cell : rows[i]) {
        figures += std::regex_match(cell, std::regex(R"( -?[0-9][0-9.,]*(e-?[0-9]+)? )"));
      }
    }
    // The smoke test runs one hard case with one choice of models.
    EXPECT_GT(figures, name == "stability" ? 0U : 3U);
    EXPECT_THAT(report, Not(HasSubstr("null")));
  }
  // Tables and plots are where a report names them, and nothing else remains.
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(folder_.path())) files += !entry.path().empty();
  EXPECT_EQ(files, kReports.size() + 7);
  for (const std::string name : {"pareto", "accuracy"}) {
    EXPECT_THAT(Read(name + ".md"), HasSubstr("](" + name + ".svg)"));
    const std::string svg = Read(name + ".svg");
    EXPECT_THAT(svg, HasSubstr("prefers-color-scheme: dark"));
    EXPECT_THAT(svg, HasSubstr(">cube, surface contact<")) << "a series of " << name << ".csv";
  }
  for (const std::string name : {"pareto", "accuracy", "stability", "peers"}) {
    const std::string csv = Read(name + ".csv");
    EXPECT_GT(std::count(csv.begin(), csv.end(), '\n'), 1) << name;
  }
}

TEST_F(Publish, SaysOfACaseThatTunnelledThatItDidAlthoughItsFigureHolds) {
  std::ofstream(File("run.json")) << R"({"contact": "spheres", "friction": "off",
    "machine": {"cpu": "a", "cores": 2, "simd": "b", "compiler": "c"},
    "cases": [{"name": "jam", "steps": 9, "figure": 0, "bound": 10, "unit": "um", "held": false,
               "what": "overlap", "tunnelled": 42, "nonfinite": 0, "penetration_um": 0}],
    "held": 0, "total": 1, "steps": 9, "tunnelled": 42, "nonfinite": 0, "penetration_um": 0})";
  test::Program jq("/usr/bin/env",
                   {"jq", "-rs", "--arg", "report", "stability.md", "--argjson", "head",
                    R"({"load": [0, 0, 0], "smoke": false, "commands": []})", "-f",
                    PALPATE_SOURCE_DIR "/tests/benchmarks/publish.jq", File("run.json")});
  ASSERT_EQ(jq.Exit(), 0) << jq.Output();
  EXPECT_THAT(jq.Output(), HasSubstr("0 of 1 case held over 9 steps"));
  EXPECT_THAT(jq.Output(), HasSubstr("`jam` (sphere contact, friction off): 42 steps tunnelled"));
  EXPECT_THAT(jq.Output(), HasSubstr("| `jam` | overlap | 10 µm | **0** |"));
}

}  // namespace
}  // namespace palpate
