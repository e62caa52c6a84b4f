#include "client/doctor/kernel_checks.h"

#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

Finding Kernel(const std::string& version, std::map<std::string, std::string> more = {}) {
  more["/proc/sys/kernel/osrelease"] = "6.1.0-30-amd64\n";
  more["/proc/sys/kernel/version"] = version + "\n";
  return CheckKernel(MadeUpHost(more).files);
}

constexpr const char* kDynamic = "#1 SMP PREEMPT_DYNAMIC Debian 6.1.124-1";
constexpr const char* kModes = "/sys/kernel/debug/sched/preempt";

TEST(Kernel, OfPreemptRtIsFine) {
  EXPECT_THAT(Kernel("#1 SMP PREEMPT_RT Debian 6.1.124-1"),
              IsOk("Linux 6.1.0-30-amd64, PREEMPT_RT"));
  EXPECT_THAT(Kernel("#1 SMP Debian 6.1.124-1", {{"/sys/kernel/realtime", "1\n"}}), IsOk());
}

TEST(Kernel, WithoutItIsAWarningByItsModeWithTheRemedy) {
  EXPECT_THAT(Kernel(kDynamic, {{kModes, "none voluntary (full)\n"}}),
              IsWarning("preemptible, but not PREEMPT_RT", "apt-get install linux-image-rt-amd64"));
  EXPECT_THAT(Kernel(kDynamic, {{kModes, "none (voluntary) full\n"}}),
              IsWarning("preemption 'voluntary'",
                        "preempt=full to GRUB_CMDLINE_LINUX in /etc/default/grub"));
  EXPECT_THAT(Kernel("#1 SMP Debian 6.1.124-1"), IsWarning("not preemptible"));
}

TEST(Kernel, SaysItsModeOnItsCommandLineWhereOnlyRootMayLook) {
  EXPECT_THAT(Kernel(kDynamic), IsWarning("does not say in which mode"));
  EXPECT_THAT(Kernel(kDynamic, {{"/proc/cmdline", "root=/dev/sda1 preempt=full quiet\n"}}),
              IsWarning("preemptible, but not PREEMPT_RT"));
  EXPECT_THAT(Kernel(kDynamic, {{"/proc/cmdline", "root=/dev/sda1 nopreempt=full\n"}}),
              IsWarning("does not say in which mode"));
}

TEST(ClockSource, IsFineWhereTheProcessorKeepsItElseAWarningWithTheKernelsOption) {
  const auto check = [](const std::string& source) {
    return CheckClockSource(
        MadeUpHost(
            {{"/sys/devices/system/clocksource/clocksource0/current_clocksource", source + "\n"}})
            .files);
  };
  for (const char* source : {"tsc", "kvm-clock"}) EXPECT_THAT(check(source), IsOk(source));
  EXPECT_THAT(check("hpet"),
              IsWarning("hpet: each look at the clock is a system call", "clocksource=tsc"));
  EXPECT_THAT(CheckClockSource(MadeUpHost().files), IsWarning("does not say which"));
}

}  // namespace
}  // namespace palpate::doctor
