#include "client/doctor/kernel_checks.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

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
  const std::string version = host.Read("/proc/sys/kernel/version").value_or("");
  const std::string kernel =
      "Linux " + host.Read("/proc/sys/kernel/osrelease").value_or("unknown") + ", ";
  if (host.Read("/sys/kernel/realtime") == "1" || version.find("PREEMPT_RT") != std::string::npos) {
    return Ok(kernel + "PREEMPT_RT");
  }
  const std::string mode = PreemptMode(host);
  if (mode == "full" || (mode.empty() && version.find("PREEMPT ") != std::string::npos)) {
    return Warning(kernel + "preemptible, but not PREEMPT_RT: nothing bounds its worst case",
                   kRealtimeKernel);
  }
  if (version.find("PREEMPT_DYNAMIC") != std::string::npos) {
    return Warning(
        kernel + (mode.empty() ? "PREEMPT_DYNAMIC, and it does not say in which mode"
                               : "preemption '" + mode + "': it may keep a loop waiting"),
        std::string(kRealtimeKernel) + "; or " + GrubLine("preempt=full") + ", and restart");
  }
  return Warning(kernel + "not preemptible: it keeps a loop waiting until it has done its own work",
                 kRealtimeKernel);
}

Finding CheckClockSource(const HostFiles& host) {
  constexpr const char* kFile = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
  // Those that the vDSO reads, without a system call.
  constexpr std::array<std::string_view, 4> kFast = {
      "tsc", "kvm-clock", "hyperv_clocksource_tsc_page", "arch_sys_counter"};
  const std::string clock = host.Read(kFile).value_or("");
  if (std::ranges::find(kFast, clock) != kFast.end()) return Ok(clock);
  if (clock.empty()) {
    return Warning("this kernel does not say which",
                   std::string("see that ") + kFile + " is there (is /sys mounted?)");
  }
  return Warning(clock + ": each look at the clock is a system call",
                 GrubLine("clocksource=tsc tsc=reliable") +
                     ", and restart; 'dmesg | grep -i tsc' says why the kernel does not trust the "
                     "processor's own");
}

}  // namespace palpate::doctor
