#include "common/program/machine.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <thread>

#include <sched.h>

namespace palpate {
namespace {

namespace fs = std::filesystem;

std::string ProcessorName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

int CoresAllowed() {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  return sched_getaffinity(0, sizeof allowed, &allowed) == 0
             ? CPU_COUNT(&allowed)
             : static_cast<int>(std::thread::hardware_concurrency());  // more than a set can hold
}

constexpr double kNoQuota = std::numeric_limits<double>::infinity();

/// Returns the cores that a control group may use, on average; infinite if it has no quota.
double QuotaOf(const fs::path& group) {
  double quota_us = 0.0, period_us = 0.0;
  if (std::ifstream both(group / "cpu.max"); both) {
    both >> quota_us >> period_us;  // fails at "max"
  } else {
    std::ifstream(group / "cpu.cfs_quota_us") >> quota_us;  // -1: none
    std::ifstream(group / "cpu.cfs_period_us") >> period_us;
  }
  return quota_us > 0.0 && period_us > 0.0 ? quota_us / period_us : kNoQuota;
}

/// Returns the least quota of a control group and those above it.  In a container the group may
/// have the host's path, which is not there: then the container's own group is the top.
double QuotaFrom(const fs::path& top, const std::string& path) {
  double least = QuotaOf(top);
  fs::path group = top;
  for (const fs::path& name : fs::path(path).relative_path()) {
    if (name == "..") return least;  // outside of the container
    least = std::min(least, QuotaOf(group /= name));
  }
  return least;
}

/// Returns the least quota of this process, from lines such as "4:cpu,cpuacct:/path" (version 1)
/// and "0::/path" (version 2).
double Quota(const fs::path& root) {
  const fs::path mounts = root / "sys/fs/cgroup";
  double least = kNoQuota;
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string path = line.substr(second + 1);
    const std::string kinds = line.substr(first + 1, second - first - 1);
    if (kinds.empty()) {
      for (const char* mount : {"", "unified"}) {
        least = std::min(least, QuotaFrom(mounts / mount, path));
      }
    } else if (("," + kinds + ",").find(",cpu,") != std::string::npos) {
      for (const std::string& mount : {kinds, std::string("cpu")}) {
        least = std::min(least, QuotaFrom(mounts / mount, path));
      }
    }
  }
  return least;
}

}  // namespace

int UsableCores(const std::string& root) {
  const int allowed = std::max(CoresAllowed(), 1);
  const double quota = std::ceil(Quota(root + "/"));
  return quota < allowed ? std::max(static_cast<int>(quota), 1) : allowed;
}

HostMachine ThisHost() {
#ifdef NDEBUG
  const std::string build = ", optimised";
#else
  const std::string build = ", with assertions: times mean nothing";
#endif
  return {.cpu = ProcessorName(), .cores = UsableCores(), .compiler = "GCC " __VERSION__ + build};
}

}  // namespace palpate
