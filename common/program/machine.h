#pragma once

#include <string>

namespace palpate {

/// The properties of a host that affect measured times.
struct HostMachine {
  std::string cpu;       ///< model name, as the processor reports it
  int cores = 0;         ///< UsableCores
  std::string compiler;  ///< that built this program, and whether it optimised
};
HostMachine ThisHost();

/// Returns how many threads are worth having, at least 1: as many as there are cores that this
/// process may run on (sched_getaffinity), and no more than the CPU quotas of its control groups,
/// rounded up; a container's is one (cpu.max, or cpu.cfs_quota_us of version 1).
/// @param root  precedes /proc and /sys; for tests
int UsableCores(const std::string& root = "");

}  // namespace palpate
