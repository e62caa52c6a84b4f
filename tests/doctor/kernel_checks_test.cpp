#include "client/doctor/kernel_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

using testing::HasSubstr;

constexpr const char* kClock = "/sys/devices/system/clocksource/clocksource0/current_clocksource";

class Kernel : public testing::Test {
 protected:
  void Is(const std::string& version) const {
    host.Write("/proc/sys/kernel/osrelease", "6.1.0-30-amd64\n");
    host.Write("/proc/sys/kernel/version", version + "\n");
  }
  MadeUpHost host;
};

TEST_F(Kernel, OfPreemptRtIsFine) {
  Is("#1 SMP PREEMPT_RT Debian 6.1.124-1");
  host.Write("/sys/kernel/realtime", "1\n");
  const Finding finding = CheckKernel(host.files);
  EXPECT_EQ(finding.status, Status::kOk);
  EXPECT_EQ(finding.found, "Linux 6.1.0-30-amd64, PREEMPT_RT");
  EXPECT_EQ(finding.remedy, "");
}

TEST_F(Kernel, ThatIsPreemptibleIsNotBoundedAndTheRemedyIsTheRealtimeOne) {
  Is("#1 SMP PREEMPT_DYNAMIC Debian 6.1.124-1");
  host.Write("/sys/kernel/debug/sched/preempt", "none voluntary (full)\n");
  const Finding finding = CheckKernel(host.files);
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.found, HasSubstr("preemptible, but not PREEMPT_RT"));
  EXPECT_THAT(finding.remedy, HasSubstr("apt-get install linux-image-rt-amd64"));
}

TEST_F(Kernel, InVoluntaryModeIsToldHowToChangeIt) {
  Is("#1 SMP PREEMPT_DYNAMIC Debian 6.1.124-1");
  host.Write("/sys/kernel/debug/sched/preempt", "none (voluntary) full\n");
  const Finding finding = CheckKernel(host.files);
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.found, HasSubstr("preemption 'voluntary'"));
  EXPECT_THAT(finding.remedy, HasSubstr("preempt=full to GRUB_CMDLINE_LINUX in /etc/default/grub"));
}

TEST_F(Kernel, SaysItsModeOnItsCommandLineWhereOnlyRootMayLook) {
  Is("#1 SMP PREEMPT_DYNAMIC Debian 6.1.124-1");
  EXPECT_THAT(CheckKernel(host.files).found, HasSubstr("does not say in which mode"));
  host.Write("/proc/cmdline", "root=/dev/sda1 preempt=full quiet\n");
  EXPECT_THAT(CheckKernel(host.files).found, HasSubstr("preemptible, but not PREEMPT_RT"));
  host.Write("/proc/cmdline", "root=/dev/sda1 nopreempt=full\n");
  EXPECT_THAT(CheckKernel(host.files).found, HasSubstr("does not say in which mode"));
}

TEST_F(Kernel, WithoutPreemptionIsAWarning) {
  Is("#1 SMP Debian 6.1.124-1");
  const Finding finding = CheckKernel(host.files);
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.found, HasSubstr("not preemptible"));
}

TEST(ClockSource, ThatTheProcessorKeepsIsFine) {
  for (const std::string source : {"tsc", "kvm-clock"}) {
    MadeUpHost host;
    host.Write(kClock, source + "\n");
    const Finding finding = CheckClockSource(host.files);
    EXPECT_EQ(finding.status, Status::kOk) << source;
    EXPECT_EQ(finding.found, source);
  }
}

TEST(ClockSource, ThatIsAskedBySystemCallIsAWarningWithTheKernelsOption) {
  MadeUpHost host;
  host.Write(kClock, "hpet\n");
  const Finding finding = CheckClockSource(host.files);
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.found, HasSubstr("hpet: each look at the clock is a system call"));
  EXPECT_THAT(finding.remedy, HasSubstr("clocksource=tsc"));
}

TEST(ClockSource, ThatIsNotSaidIsAWarning) {
  MadeUpHost host;
  EXPECT_EQ(CheckClockSource(host.files).status, Status::kWarning);
}

}  // namespace
}  // namespace palpate::doctor
