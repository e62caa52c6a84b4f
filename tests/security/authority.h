#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/support/program.h"

namespace palpate::test {

/// An authority made by the script, in a folder that is removed with it.
class Authority {
 public:
  explicit Authority(const std::string& name)
      : folder_(std::filesystem::temp_directory_path() /
                ("palpate_security_" + name + "_" + std::to_string(getpid()))) {
    std::filesystem::remove_all(folder_);
    Script({"new", folder_});
  }
  ~Authority() { std::filesystem::remove_all(folder_); }
  Authority(const Authority&) = delete;
  Authority& operator=(const Authority&) = delete;

  /// Makes an identity; returns its folder.
  std::string Add(const std::string& role, const std::string& name) const {
    Script({"add", folder_, role, name});
    return folder_ / "identities" / name;
  }
  /// The folder with the authorities' own keys.
  std::filesystem::path keys() const { return folder_ / "authority"; }

  static void Script(std::vector<std::string> arguments, int exit = 0) {
    Program script(PALPATE_SOURCE_DIR "/deploy/security/identities", std::move(arguments));
    EXPECT_EQ(script.Exit(60.0), exit) << script.Output();
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace palpate::test
