#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tests/integration/rig.h"

namespace palpate::test {

class ReplayerProgram : public Program {
 public:
  explicit ReplayerProgram(std::vector<std::string> arguments)
      : Program(PALPATE_BIN_DIR "/palpate-replay", std::move(arguments)) {}
};

inline const std::string kDomainText = std::to_string(kDomain);

}  // namespace palpate::test
