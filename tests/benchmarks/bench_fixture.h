#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "tests/support/program.h"

namespace palpate::test {

/// palpate-bench in a folder of its own, which goes with the test.
class PalpateBench : public testing::Test {
 protected:
  PalpateBench() : folder_(std::filesystem::temp_directory_path() / ("palpate-bench-" + Unique())) {
    std::filesystem::create_directory(folder_);
  }
  ~PalpateBench() override { std::filesystem::remove_all(folder_); }

  std::string File(const std::string& name) const { return (folder_ / name).string(); }
  nlohmann::json Json(const std::string& name) const {
    return nlohmann::json::parse(std::ifstream(File(name)));
  }
  std::string Read(const std::string& name) const {
    const std::ifstream file(File(name));
    EXPECT_TRUE(file) << name;
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }
  /// Runs it to its end; what it said is in said_.
  int Run(std::vector<std::string> arguments) {
    Program program(PALPATE_BIN_DIR "/palpate-bench", std::move(arguments));
    const int status = program.Exit(100.0);
    said_ = program.Output();
    return status;
  }
  /// The picture that plots.py draws of a file with figures.
  std::string Drawn(const std::string& name) {
    Program program(PALPATE_SOURCE_DIR "/tests/benchmarks/plots.py", {File(name)});
    EXPECT_EQ(program.Exit(30.0), 0) << program.Output();
    return Read(std::filesystem::path(name).replace_extension(".svg"));
  }

  std::string said_;
  std::filesystem::path folder_;

 private:
  static std::string Unique() {
    return std::to_string(getpid()) + "-" +
           testing::UnitTest::GetInstance()->current_test_info()->name();
  }
};

}  // namespace palpate::test
