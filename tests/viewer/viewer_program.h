#pragma once

#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "tests/support/program.h"
#include "tests/support/web_client.h"

namespace palpate::test {

/// The real palpate-viewer, at a port of its own, until this object goes.
class ViewerProgram {
 public:
  explicit ViewerProgram(int domain, const std::vector<std::string>& more = {}) {
    program_ = std::make_unique<Program>(
        PALPATE_BIN_DIR "/palpate-viewer",
        Joined({"--http", "0", "--transport", "udp", "--domain", std::to_string(domain)}, more));
    EXPECT_TRUE(program_->Says("ready: page http")) << program_->Output();
    EXPECT_TRUE(program_->Says("/; domain"));
    const std::string& said = program_->Output();
    const std::size_t end = said.find("/; domain");
    port_ = std::atoi(said.c_str() + said.rfind(':', end) + 1);
  }

  int port() const { return port_; }
  Program& program() { return *program_; }
  nlohmann::json Health(const std::map<std::string, std::string>& headers = {}) {
    return nlohmann::json::parse(Get(port_, "/healthz", headers).body);
  }
  /// Asks until the gateway says so.
  bool Until(const std::function<bool(const nlohmann::json&)>& condition,
             const std::map<std::string, std::string>& headers = {}) {
    for (int i = 0; i < 2000; ++i) {
      if (condition(Health(headers))) return true;
      usleep(10'000);
    }
    return false;
  }
  bool KnowsScenes(std::size_t n, const std::map<std::string, std::string>& headers = {}) {
    return Until([n](const nlohmann::json& health) { return health["scenes"].size() == n; },
                 headers);
  }

 private:
  std::unique_ptr<Program> program_;
  int port_ = 0;
};

}  // namespace palpate::test
