#include <algorithm>
#include <array>
#include <cstdlib>
#include <sstream>
#include <string_view>
#include <thread>

#include <linux/capability.h>
#include <sys/resource.h>

#include "client/doctor/checks.h"

namespace palpate::doctor {
namespace {

constexpr const char* kRealtimeKernel = "sudo apt-get install linux-image-rt-amd64, then boot it";

/// Returns the mode of a PREEMPT_DYNAMIC kernel: "full", from "none voluntary (full)" if debugfs is
/// readable (by root), or else from its command line; empty if neither says.
std::string PreemptMode(const HostFiles& host) {
  if (const auto modes = host.Read("/sys/kernel/debug/sched/preempt")) {
    const std::size_t open = modes->find('(');
    const std::size_t close = modes->find(')');
    if (open != std::string::npos && close != std::string::npos && open < close) {
      return modes->substr(open + 1, close - open - 1);
    }
  }
  const std::string line = host.Read("/proc/cmdline").value_or("");
  const std::string option = "preempt=";
  const std::size_t at = (" " + line).find(" " + option);
  if (at == std::string::npos) return "";
  const std::size_t begin = at + option.size();
  return line.substr(begin, line.find(' ', begin) - begin);
}

const std::string kGroupsLimits =
    "/etc/security/limits.d/palpate.conf (the package palpate-common does), sudo adduser $USER "
    "palpate, and log in again";

std::optional<long long> Limit(__rlimit_resource_t resource, long long unit) {
  rlimit limit{};
  getrlimit(resource, &limit);
  if (limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  return static_cast<long long>(limit.rlim_cur) / unit;
}

std::string Text(const std::optional<long long>& limit) {
  return limit ? std::to_string(*limit) : "unlimited";
}

bool HasCapability(const HostFiles& host, int capability) {
  std::istringstream status(host.Read("/proc/self/status").value_or(""));
  for (std::string line; std::getline(status, line);) {
    if (!line.starts_with("CapEff:")) continue;
    const unsigned long long bits = std::strtoull(line.c_str() + 7, nullptr, 16);
    return (bits >> capability & 1) != 0;
  }
  return false;
}

/// Returns the file that sets the real-time share of this process's group, under cgroup v1 with
/// CONFIG_RT_GROUP_SCHED, if there is one.
std::optional<std::string> GroupShareFile(const HostFiles& host) {
  std::istringstream groups(host.Read("/proc/self/cgroup").value_or(""));
  for (std::string line; std::getline(groups, line);) {
    // "1:cpu,cpuacct:/palpate"
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    std::istringstream controllers(line.substr(first + 1, second - first - 1));
    bool of_cpu = false;
    for (std::string name; std::getline(controllers, name, ',');) of_cpu |= name == "cpu";
    if (!of_cpu) continue;
    const std::string group = line.substr(second + 1) == "/" ? "" : line.substr(second + 1);
    for (const std::string folder : {"/sys/fs/cgroup/cpu", "/sys/fs/cgroup/cpu,cpuacct"}) {
      // In a container the group's own folder is the mount's root.
      for (const std::string& place : {folder + group, folder}) {
        const std::string file = place + "/cpu.rt_runtime_us";
        if (host.Has(file)) return file;
      }
    }
  }
  return std::nullopt;
}

}  // namespace

Finding CheckKernel(const HostFiles& host) {
  const std::string version = host.Read("/proc/sys/kernel/version").value_or("");
  const std::string kernel =
      "Linux " + host.Read("/proc/sys/kernel/osrelease").value_or("unknown") + ", ";
  if (host.Read("/sys/kernel/realtime") == "1" || version.find("PREEMPT_RT") != std::string::npos) {
    return Ok(kernel + "PREEMPT_RT");
  }
  const std::string mode = PreemptMode(host);
  if (mode == "full" || (mode.empty() && version.find("PREEMPT ") != std::string::npos)) {
    return Warning(kernel + "preemptible, but not PREEMPT_RT: its worst-case latency is unbounded",
                   kRealtimeKernel);
  }
  if (version.find("PREEMPT_DYNAMIC") != std::string::npos) {
    return Warning(
        kernel + (mode.empty() ? "PREEMPT_DYNAMIC, in an unknown mode"
                               : "preemption '" + mode + "': it can delay a loop"),
        std::string(kRealtimeKernel) + "; or " + GrubLine("preempt=full") + ", and restart");
  }
  return Warning(
      kernel + "not preemptible: the kernel delays a loop until it has finished its own work",
      kRealtimeKernel);
}

Finding CheckClockSource(const HostFiles& host) {
  constexpr const char* kFile = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
  // Clock sources that the vDSO reads without a system call.
  constexpr std::array<std::string_view, 4> kFast = {
      "tsc", "kvm-clock", "hyperv_clocksource_tsc_page", "arch_sys_counter"};
  const std::string clock = host.Read(kFile).value_or("");
  if (std::ranges::find(kFast, clock) != kFast.end()) return Ok(clock);
  if (clock.empty()) {
    return Warning("the kernel does not report it",
                   std::string("see that ") + kFile + " exists (mount /sys)");
  }
  return Warning(clock + ": each reading of the clock is a system call",
                 GrubLine("clocksource=tsc tsc=reliable") +
                     ", and reboot; 'dmesg | grep -i tsc' says why the kernel does not trust the "
                     "processor's clock");
}

Rights TryRights(const RealtimeOptions& realtime) {
  Rights rights;
  rights.rtprio = Limit(RLIMIT_RTPRIO, 1);
  rights.memlock_kB = Limit(RLIMIT_MEMLOCK, 1024);
  std::thread([&] {
    const RealtimeReport report =
        EnterRealtime({.mode = RealtimeMode::kPrefer, .priority = realtime.priority});
    rights.fifo = report.fifo;
    rights.memory_locked = report.memory_locked;
  }).join();
  return rights;
}

Finding CheckScheduling(const HostFiles& host, const Rights& rights, int priority) {
  const bool capable = HasCapability(host, CAP_SYS_NICE);
  const std::string wanted = "SCHED_FIFO " + std::to_string(priority);
  if (rights.fifo) return Ok(wanted + " is granted");
  const std::string refused = wanted + " is refused";
  const auto share_file = GroupShareFile(host);
  if ((capable || rights.rtprio.value_or(priority) >= priority) && share_file &&
      host.ReadNumber(*share_file).value_or(-1) == 0) {
    return Fault(refused + ": the control group of this process has no real-time share (" +
                     *share_file + " is 0)",
                 "echo 400000 | sudo tee " + *share_file +
                     " (first the parent groups, 800000 each), or start the program outside the "
                     "group; in a container, --cpu-rt-runtime=400000 --cpu-rt-period=1000000");
  }
  if (!capable && rights.rtprio.value_or(priority) < priority) {
    return Fault(
        refused + ": ulimit -r is " + Text(rights.rtprio) + ", and CAP_SYS_NICE is missing",
        "put '@palpate - rtprio 45' and '@palpate - memlock unlimited' into " + kGroupsLimits +
            "; for a service, LimitRTPRIO=45; in a container, --cap-add SYS_NICE --ulimit "
            "rtprio=45:45");
  }
  return Fault(refused + ", though limits and capabilities allow it",
               "the container or systemd sandbox forbids it: allow sched_setscheduler in its "
               "seccomp profile, or set RestrictRealtime=no in its unit; for rootless podman, "
               "raise the user's limits on the host and give --ulimit host");
}

Finding CheckLockedMemory(const Rights& rights) {
  if (rights.memory_locked) return Ok("is granted");
  return Warning("is refused (ulimit -l is " + Text(rights.memlock_kB) +
                     " kB): under memory pressure, a loop waits for the disk",
                 "put '@palpate - memlock unlimited' into " + kGroupsLimits +
                     "; for a service, LimitMEMLOCK=infinity; in a container, --ulimit "
                     "memlock=-1:-1");
}

Finding CheckThrottling(const HostFiles& host) {
  const auto runtime_us = host.ReadNumber("/proc/sys/kernel/sched_rt_runtime_us");
  const auto period_us = host.ReadNumber("/proc/sys/kernel/sched_rt_period_us");
  if (!runtime_us || !period_us) return Ok("this kernel has none");
  constexpr const char* kRemedy =
      "sudo sysctl kernel.sched_rt_runtime_us=950000, and the same line in "
      "/etc/sysctl.d/palpate.conf";
  if (*runtime_us < 0) {
    return Warning("off: a real-time thread that spins blocks the host", kRemedy);
  }
  const long long share = 100 * *runtime_us / (*period_us > 0 ? *period_us : 1);
  const std::string found =
      "real-time threads may take " + std::to_string(share) + " % of the time";
  if (share >= 50) return Ok(found);
  const std::string held_up = found + ": loops stop when it is used up";
  return share == 0 ? Fault(held_up, kRemedy) : Warning(held_up, kRemedy);
}

}  // namespace palpate::doctor
