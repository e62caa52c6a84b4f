#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "client/doctor/checks.h"

namespace palpate::doctor {
namespace {

constexpr int kMostCores = 8192;  // NR_CPUS of the largest kernels
constexpr const char* kCores = "/sys/devices/system/cpu";
/// A sleep state that takes longer to leave costs over a tenth of a pose's whole round trip, twice.
constexpr long long kMostWakeUp_us = 10;
/// With fewer cores none can be reserved: sessions, log and viewers need one, DDS and
/// interrupts another.
constexpr std::size_t kEnoughCores = 4;

/// Returns the cores listed in a file below kCores; `otherwise` if the file does not exist.
std::set<int> CoresIn(const HostFiles& host, const std::string& file,
                      const std::string& otherwise = "") {
  return ParseCores(host.Read(std::string(kCores) + "/" + file).value_or(otherwise));
}

/// Returns the folders of the cores that run, such as "/sys/devices/system/cpu/cpu0".
std::vector<std::string> CoreFolders(const HostFiles& host) {
  std::vector<std::string> folders;
  for (const int core : CoresIn(host, "online", "0")) {
    folders.push_back(kCores + std::string("/cpu") + std::to_string(core));
  }
  return folders;
}

/// Returns the longest wake-up latency [us] that programs allow all cores.  Programs set it by
/// holding /dev/cpu_dma_latency open: 4 bytes, 2,000,000,000 if no program does.
std::optional<std::int32_t> AllowedWakeUp_us(const HostFiles& host) {
  const auto bytes = host.Read("/dev/cpu_dma_latency");
  std::int32_t latency = 0;
  if (!bytes || bytes->size() != sizeof latency) return std::nullopt;
  std::memcpy(&latency, bytes->data(), sizeof latency);
  return latency;
}

struct SleepState {
  std::string name;
  long long wake_up_us = 0;
};

/// Returns the deepest sleep state that any core may enter.
std::optional<SleepState> DeepestState(const HostFiles& host) {
  std::optional<SleepState> deepest;
  for (const std::string& core : CoreFolders(host)) {
    for (const std::string& state : host.Names(core + "/cpuidle", "state")) {
      const std::string folder = core + "/cpuidle/" + state;
      if (host.ReadNumber(folder + "/disable").value_or(0) != 0) continue;
      const long long wake_up_us = host.ReadNumber(folder + "/latency").value_or(0);
      if (!deepest || wake_up_us > deepest->wake_up_us) {
        deepest = {host.Read(folder + "/name").value_or(state), wake_up_us};
      }
    }
  }
  return deepest;
}

}  // namespace

std::set<int> ParseCores(const std::string& list) {
  std::set<int> cores;
  std::istringstream ranges(list);
  for (std::string range; std::getline(ranges, range, ',');) {
    char* end = nullptr;
    const long first = std::strtol(range.c_str(), &end, 10);
    if (end == range.c_str()) continue;
    const long last = *end == '-' ? std::strtol(end + 1, nullptr, 10) : first;
    for (long core = first; core <= last && core < kMostCores; ++core) {
      cores.insert(static_cast<int>(core));
    }
  }
  return cores;
}

std::string ToText(const std::set<int>& cores) {
  std::string text;
  for (auto first = cores.begin(); first != cores.end();) {
    auto last = first;
    while (std::next(last) != cores.end() && *std::next(last) == *last + 1) ++last;
    text.append(text.empty() ? "" : ",").append(std::to_string(*first));
    if (last != first) text.append("-").append(std::to_string(*last));
    first = std::next(last);
  }
  return text;
}

Finding CheckGovernor(const HostFiles& host) {
  std::set<std::string> governors;
  for (const std::string& core : CoreFolders(host)) {
    if (const auto governor = host.Read(core + "/cpufreq/scaling_governor")) {
      governors.insert(*governor);
    }
  }
  if (governors.empty()) {
    return Ok("the kernel does not change it (a virtual machine, or a fixed frequency)");
  }
  std::string found;
  for (const std::string& governor : governors) {
    found += (found.empty() ? "governor " : ", ") + governor;
  }
  if (governors == std::set<std::string>{"performance"}) return Ok(found);
  return Warning(
      found + ": a core that waits for poses runs slower",
      "sudo cpupower frequency-set -g performance (package linux-cpupower), after each boot");
}

Finding CheckIdleStates(const HostFiles& host) {
  const auto allowed_us = AllowedWakeUp_us(host);
  if (allowed_us && *allowed_us <= kMostWakeUp_us) {
    return Ok("a program holds /dev/cpu_dma_latency at " + std::to_string(*allowed_us) +
              " us: no core sleeps deeper");
  }
  const auto deepest = DeepestState(host);
  if (!deepest)
    return Ok("none under this kernel's control (in a virtual machine, the host controls them)");
  const std::string found = "the deepest is " + deepest->name + ", " +
                            std::to_string(deepest->wake_up_us) + " us to leave";
  if (deepest->wake_up_us <= kMostWakeUp_us) return Ok(found);
  return Warning(found,
                 "sudo cpupower idle-set -D 10 (package linux-cpupower), after each boot; or " +
                     GrubLine("processor.max_cstate=1 intel_idle.max_cstate=1") + ", and restart");
}

Finding CheckIsolatedCores(const HostFiles& host) {
  const auto cores = CoresIn(host, "online", "0");
  const auto isolated = CoresIn(host, "isolated");
  const std::string found = std::to_string(cores.size()) + (cores.size() == 1 ? " core" : " cores");
  if (!isolated.empty()) {
    const std::string which = ToText(isolated);
    const std::string given = found + ", " + which + " isolated: give one to --cpu";
    if (std::ranges::includes(CoresIn(host, "nohz_full"), isolated)) return Ok(given);
    return Warning(given + "; the kernel's tick still interrupts it at least 100 times per second",
                   GrubLine("nohz_full=" + which + " rcu_nocbs=" + which) + ", and restart");
  }
  if (cores.size() >= kEnoughCores) {
    const std::string last = std::to_string(*cores.rbegin());
    return Warning(found + ", none isolated: the loops share a core with other programs",
                   GrubLine("isolcpus=" + last + " nohz_full=" + last + " rcu_nocbs=" + last) +
                       ", restart, and start palpate-server with --cpu " + last);
  }
  return Warning(
      found + ": too few to reserve one for the loops, which share a core with other programs",
      "run no other programs during a session (no browser, no desktop), or use a host with " +
          std::to_string(kEnoughCores) + " cores");
}

Finding CheckHyperThreading(const HostFiles& host) {
  if (host.ReadNumber(std::string(kCores) + "/smt/active").value_or(0) == 0) {
    return Ok("off, or not supported");
  }
  // An isolated core whose sibling is isolated too has its execution units for itself.
  const auto isolated = CoresIn(host, "isolated");
  const bool whole = std::ranges::any_of(isolated, [&](int core) {
    const auto siblings =
        CoresIn(host, "cpu" + std::to_string(core) + "/topology/thread_siblings_list");
    return !siblings.empty() && std::ranges::includes(isolated, siblings);
  });
  if (whole) return Ok("on, but both threads of a core are isolated");
  return Warning(
      "on: a loop shares its core with programs on the sibling thread",
      "echo off | sudo tee /sys/devices/system/cpu/smt/control, or nosmt on the kernel's command "
      "line (/etc/default/grub, sudo update-grub), or isolate both threads of a core "
      "(/sys/devices/system/cpu/cpu*/topology/thread_siblings_list names them)");
}

}  // namespace palpate::doctor
