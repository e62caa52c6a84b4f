#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/folder.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"

namespace palpate::test {

/// Runs palpate-bench in a temporary folder, which is deleted after the test.
class PalpateBench : public testing::Test {
 protected:
  std::string File(const std::string& name) const { return folder_ / name; }
  std::string Read(const std::string& name) const { return ReadWholeFile(File(name)); }
  nlohmann::json Json(const std::string& name) const {
    return nlohmann::json::parse(std::ifstream(File(name)));
  }
  /// Runs it to its end; fills in said_ with its output.
  int Run(std::vector<std::string> arguments) {
    Program program(PALPATE_BIN_DIR "/palpate-bench", std::move(arguments));
    const int status = program.Exit(100.0);
    said_ = program.Output();
    return status;
  }
  /// Returns its measurements, which it writes to figures.json.
  nlohmann::json Figures(std::vector<std::string> arguments) {
    std::filesystem::remove(File("figures.json"));  // removes figures of an earlier run
    EXPECT_EQ(Run(Joined(std::move(arguments), {"--json", File("figures.json")})), 0) << said_;
    return Json("figures.json");
  }
  /// Returns the picture that plots.py draws from a file of figures.
  std::string Drawn(const std::string& name) {
    Program program(PALPATE_SOURCE_DIR "/tests/benchmarks/plots.py", {File(name)});
    EXPECT_EQ(program.Exit(30.0), 0) << program.Output();
    return Read(std::filesystem::path(name).replace_extension(".svg"));
  }

  std::string said_;
  const Folder folder_;
};

}  // namespace palpate::test
