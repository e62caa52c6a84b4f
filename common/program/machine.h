#pragma once

#include <string>

namespace palpate {

/// The properties of a host that affect measured times.
struct HostMachine {
  std::string cpu;       ///< model name, as the processor reports it
  int cores = 0;         ///< number that this process may use
  std::string compiler;  ///< that built this program, and whether it optimised
};
HostMachine ThisHost();

}  // namespace palpate
