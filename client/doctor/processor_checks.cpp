#include "client/doctor/processor_checks.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "client/doctor/core_list.h"

namespace palpate::doctor {
namespace {

constexpr const char* kCores = "/sys/devices/system/cpu";
/// A sleep that takes longer to leave is a tenth of what a pose's whole way takes, and comes twice.
constexpr long long kMostWakeUp_us = 10;
/// With fewer, none can be given away: sessions, log and viewers need one, DDS and interrupts
/// another.
constexpr std::size_t kEnoughCores = 4;

/// Its folders, as "/sys/devices/system/cpu/cpu0", for those that run.
std::vector<std::string> CoreFolders(const HostFiles& host) {
  std::vector<std::string> folders;
  for (const int core : ParseCores(host.Read(std::string(kCores) + "/online").value_or("0"))) {
    folders.push_back(kCores + std::string("/cpu") + std::to_string(core));
  }
  return folders;
}

/// The longest time [us] that all may take to wake up, as programs ask for it by holding
/// /dev/cpu_dma_latency open: 4 bytes, and 2,000,000,000 where nobody asks.
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

/// The deepest that any core may take.
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

Finding CheckGovernor(const HostFiles& host) {
  std::set<std::string> governors;
  for (const std::string& core : CoreFolders(host)) {
    if (const auto governor = host.Read(core + "/cpufreq/scaling_governor")) {
      governors.insert(*governor);
    }
  }
  Finding finding{.check = "processor frequency"};
  if (governors.empty()) {
    finding.found = "the kernel does not change it (a virtual machine, or a fixed frequency)";
    return finding;
  }
  for (const std::string& governor : governors) {
    finding.found += (finding.found.empty() ? "governor " : ", ") + governor;
  }
  if (governors == std::set<std::string>{"performance"}) return finding;
  finding.status = Status::kWarning;
  finding.found += ": a core that waits for poses is slowed down";
  finding.remedy =
      "sudo cpupower frequency-set -g performance (package linux-cpupower), after each start of "
      "the host";
  return finding;
}

Finding CheckIdleStates(const HostFiles& host) {
  Finding finding{.check = "idle states"};
  const auto allowed_us = AllowedWakeUp_us(host);
  if (allowed_us && *allowed_us <= kMostWakeUp_us) {
    finding.found = "a program holds /dev/cpu_dma_latency at " + std::to_string(*allowed_us) +
                    " us: no core sleeps deeper";
    return finding;
  }
  const auto deepest = DeepestState(host);
  if (!deepest) {
    finding.found = "none that this kernel rules (a virtual machine: its host does)";
    return finding;
  }
  finding.found = "the deepest is " + deepest->name + ", " + std::to_string(deepest->wake_up_us) +
                  " us to leave";
  if (deepest->wake_up_us <= kMostWakeUp_us) return finding;
  finding.status = Status::kWarning;
  finding.remedy =
      "sudo cpupower idle-set -D 10 (package linux-cpupower), after each start of the host; or add "
      "processor.max_cstate=1 intel_idle.max_cstate=1 to GRUB_CMDLINE_LINUX in /etc/default/grub, "
      "run sudo update-grub, and restart";
  return finding;
}

Finding CheckIsolatedCores(const HostFiles& host) {
  const auto cores = ParseCores(host.Read(std::string(kCores) + "/online").value_or("0"));
  const auto isolated = ParseCores(host.Read(std::string(kCores) + "/isolated").value_or(""));
  const auto tickless = ParseCores(host.Read(std::string(kCores) + "/nohz_full").value_or(""));
  Finding finding{.check = "isolated cores", .status = Status::kWarning};
  finding.found = std::to_string(cores.size()) + (cores.size() == 1 ? " core" : " cores");
  if (!isolated.empty()) {
    finding.found += ", " + ToText(isolated) + " isolated: give it with --cpu";
    if (std::ranges::includes(tickless, isolated)) {
      finding.status = Status::kOk;
      return finding;
    }
    finding.found += "; the kernel's tick still interrupts it a hundred times a second and more";
    finding.remedy =
        "add nohz_full=" + ToText(isolated) + " rcu_nocbs=" + ToText(isolated) +
        " to GRUB_CMDLINE_LINUX in /etc/default/grub, run sudo update-grub, and restart";
  } else if (cores.size() >= kEnoughCores) {
    const std::string last = std::to_string(*cores.rbegin());
    finding.found += ", none isolated: the loops share theirs with whatever runs";
    finding.remedy =
        "add isolcpus=" + last + " nohz_full=" + last + " rcu_nocbs=" + last +
        " to GRUB_CMDLINE_LINUX in /etc/default/grub, run sudo update-grub, restart, and start "
        "palpate-server with --cpu " +
        last;
  } else {
    finding.found += ": none to spare for the loops, which share theirs with whatever runs";
    finding.remedy =
        "run nothing else beside a hand (no browser, no desktop), or take a host with " +
        std::to_string(kEnoughCores) + " cores";
  }
  return finding;
}

Finding CheckHyperThreading(const HostFiles& host) {
  Finding finding{.check = "hyper-threading"};
  if (host.ReadNumber(std::string(kCores) + "/smt/active").value_or(0) == 0) {
    finding.found = "off, or not there";
    return finding;
  }
  // An isolated core whose other half is isolated too has its units for itself.
  const auto isolated = ParseCores(host.Read(std::string(kCores) + "/isolated").value_or(""));
  const bool whole = std::ranges::any_of(isolated, [&](int core) {
    const auto siblings = ParseCores(host.Read(kCores + std::string("/cpu") + std::to_string(core) +
                                               "/topology/thread_siblings_list")
                                         .value_or(""));
    return !siblings.empty() && std::ranges::includes(isolated, siblings);
  });
  if (whole) {
    finding.found = "on, and an isolated core has both of its halves for itself";
    return finding;
  }
  finding.status = Status::kWarning;
  finding.found = "on: a loop shares its core's units with whatever runs on the other half";
  finding.remedy =
      "echo off | sudo tee /sys/devices/system/cpu/smt/control, or nosmt on the kernel's command "
      "line (/etc/default/grub, sudo update-grub), or isolate both halves of a core "
      "(/sys/devices/system/cpu/cpu*/topology/thread_siblings_list names them)";
  return finding;
}

}  // namespace palpate::doctor
