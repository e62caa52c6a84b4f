#pragma once

#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace palpate::test {

/// What read_back.mjs finds in a recording; nullopt without Node.js or its packages.
inline std::optional<nlohmann::json> ReadByOthers(const std::string& file) {
  const std::string packages = PALPATE_SOURCE_DIR "/build/mcap";
  if (!std::filesystem::exists(packages + "/node_modules") ||
      std::system("node --version >/dev/null 2>&1") != 0) {
    return std::nullopt;
  }
  const std::string command = "node '" PALPATE_SOURCE_DIR "/tests/recorder/read_back.mjs' '" +
                              packages + "' '" + file + "'";
  std::FILE* const pipe = popen(command.c_str(), "r");
  std::string text;
  char part[65536];
  for (std::size_t n = 0; (n = std::fread(part, 1, sizeof part, pipe)) > 0;) text.append(part, n);
  EXPECT_EQ(pclose(pipe), 0) << command;
  return nlohmann::json::parse(text, nullptr, false);
}

}  // namespace palpate::test
