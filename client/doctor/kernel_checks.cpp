#include "client/doctor/kernel_checks.h"

#include <array>
#include <optional>
#include <string>

namespace palpate::doctor {
namespace {

constexpr const char* kRealtimeKernel =
    "sudo apt-get install linux-image-rt-amd64, then restart into it";

/// The mode that a kernel of PREEMPT_DYNAMIC runs in: "full", from "none voluntary (full)" where
/// debugfs may be read (by root), else from its command line; empty where neither says.
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

}  // namespace

Finding CheckKernel(const HostFiles& host) {
  const std::string release = host.Read("/proc/sys/kernel/osrelease").value_or("unknown");
  const std::string version = host.Read("/proc/sys/kernel/version").value_or("");
  Finding finding{.check = "kernel", .found = "Linux " + release};
  if (host.Read("/sys/kernel/realtime") == "1" || version.find("PREEMPT_RT") != std::string::npos) {
    finding.found += ", PREEMPT_RT";
    return finding;
  }
  finding.status = Status::kWarning;
  const std::string mode = PreemptMode(host);
  if (mode == "full" || (mode.empty() && version.find("PREEMPT ") != std::string::npos)) {
    finding.found += ", preemptible, but not PREEMPT_RT: nothing bounds its worst case";
    finding.remedy = kRealtimeKernel;
  } else if (version.find("PREEMPT_DYNAMIC") != std::string::npos) {
    finding.found += mode.empty() ? ", PREEMPT_DYNAMIC, and it does not say in which mode"
                                  : ", preemption '" + mode + "': it may keep a loop waiting";
    finding.remedy = std::string(kRealtimeKernel) +
                     "; or add preempt=full to GRUB_CMDLINE_LINUX in /etc/default/grub, run "
                     "sudo update-grub, and restart";
  } else {
    finding.found += ", not preemptible: it keeps a loop waiting until it has done its own work";
    finding.remedy = kRealtimeKernel;
  }
  return finding;
}

Finding CheckClockSource(const HostFiles& host) {
  constexpr const char* kFile = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
  // Those that the vDSO reads, without a system call.
  constexpr std::array kFast = {"tsc", "kvm-clock", "hyperv_clocksource_tsc_page",
                                "arch_sys_counter"};
  Finding finding{.check = "clock source", .found = host.Read(kFile).value_or("")};
  for (const std::string fast : kFast) {
    if (finding.found == fast) return finding;
  }
  finding.status = Status::kWarning;
  if (finding.found.empty()) {
    finding.found = "this kernel does not say which";
    finding.remedy = std::string("see that ") + kFile + " is there (is /sys mounted?)";
    return finding;
  }
  finding.found += ": each look at the clock is a system call";
  finding.remedy =
      "add clocksource=tsc tsc=reliable to GRUB_CMDLINE_LINUX in /etc/default/grub, run sudo "
      "update-grub, and restart; 'dmesg | grep -i tsc' says why the kernel does not trust the "
      "processor's own";
  return finding;
}

}  // namespace palpate::doctor
