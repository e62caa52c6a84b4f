#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/faults/lab.h"

namespace palpate::faults {

/// Something that goes wrong, and what must be true nevertheless.
struct Fault {
  std::string name;   ///< "server-killed"
  std::string story;  ///< what is done
  bool quick;         ///< short enough for every run of the tests
  std::function<std::vector<Finding>(int domain)> run;
};

/// All of them, in the order of the table.
const std::vector<Fault>& AllFaults();

/// Kills, freezes and starts again what a seed says, one after another, and looks at the same
/// things at the end.
std::vector<Finding> RandomFaults(int domain, std::uint64_t seed, int rounds);

}  // namespace palpate::faults
