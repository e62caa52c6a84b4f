#include <cstdint>

#include <sched.h>

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
  EXPECT_THAT(Kernel(kDynamic), IsWarning("in an unknown mode"));
  EXPECT_THAT(Kernel(kDynamic, {{"/proc/cmdline", "root=/dev/sda1 preempt=full quiet\n"}}),
              IsWarning("preemptible, but not PREEMPT_RT"));
  EXPECT_THAT(Kernel(kDynamic, {{"/proc/cmdline", "root=/dev/sda1 nopreempt=full\n"}}),
              IsWarning("in an unknown mode"));
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
              IsWarning("hpet: each reading of the clock is a system call", "clocksource=tsc"));
  EXPECT_THAT(CheckClockSource(MadeUpHost().files), IsWarning("does not report it"));
}

/// A host whose process has these capabilities.
Finding Check(const Rights& rights, const std::string& capabilities,
              std::map<std::string, std::string> more = {}) {
  more["/proc/self/status"] = "Name:\tx\nCapEff:\t" + capabilities + "\n";
  return CheckScheduling(MadeUpHost(more).files, rights, 40);
}
constexpr const char* kNone = "0000000000000000";
constexpr const char* kNice = "0000000000800000";

TEST(Scheduling, IsGrantedOrRefusedByWhatIsNamed) {
  EXPECT_THAT(Check({.fifo = true}, kNone), IsOk("SCHED_FIFO 40 is granted"));
  const Finding by_limit = Check({.rtprio = 0}, kNone);
  EXPECT_THAT(by_limit, IsFault("ulimit -r is 0, and CAP_SYS_NICE is missing",
                                "/etc/security/limits.d/palpate.conf"));
  EXPECT_THAT(by_limit, IsFault("", "adduser $USER palpate"));
  for (const std::string where : {"/lab", ""}) {  // on the host, and in a container
    const std::string file = "/sys/fs/cgroup/cpu" + where + "/cpu.rt_runtime_us";
    EXPECT_THAT(Check({.rtprio = 0}, kNice,
                      {{"/proc/self/cgroup", "9:name=systemd:/lab\n1:cpu,cpuacct:/lab\n0::/\n"},
                       {file, "0\n"}}),
                IsFault("has no real-time share", file));
  }
  const Finding by_sandbox =
      Check({.rtprio = std::nullopt}, kNone, {{"/proc/self/cgroup", "0::/user.slice\n"}});
  EXPECT_THAT(by_sandbox, IsFault("", "seccomp"));
  EXPECT_THAT(by_sandbox, IsFault("", "RestrictRealtime=no"));
}

TEST(LockedMemory, IsFineWhereItIsGrantedAndAWarningWithItsLimitWhereNot) {
  EXPECT_THAT(CheckLockedMemory({.memory_locked = true}), IsOk());
  EXPECT_THAT(CheckLockedMemory({.memlock_kB = 8192}),
              IsWarning("ulimit -l is 8192 kB", "memlock unlimited"));
}

TEST(Throttling, IsANetThatShouldStayWhereItIs) {
  const auto check = [](const std::string& runtime_us) {
    return CheckThrottling(MadeUpHost({{"/proc/sys/kernel/sched_rt_runtime_us", runtime_us + "\n"},
                                       {"/proc/sys/kernel/sched_rt_period_us", "1000000\n"}})
                               .files);
  };
  EXPECT_THAT(check("950000"), IsOk());
  EXPECT_THAT(check("-1"), IsWarning());
  EXPECT_THAT(check("100000"), IsWarning());
  EXPECT_THAT(check("0"), IsFault("", "sysctl kernel.sched_rt_runtime_us=950000"));
  EXPECT_THAT(CheckThrottling(MadeUpHost().files), IsOk());
}

TEST(Rights, AreTriedWithoutLeavingThisThreadARealtimeOne) {
  TryRights({});
  EXPECT_EQ(sched_getscheduler(0), SCHED_OTHER);
}

using testing::ElementsAre;

const std::string kCpu = "/sys/devices/system/cpu";

class Processor : public testing::Test {
 protected:
  /// Writes files below kCpu.
  void Has(const std::map<std::string, std::string>& texts) const {
    for (const auto& [file, text] : texts) host.Write(kCpu + "/" + file, text + "\n");
  }
  void IdleState(int state, const std::string& name, int latency_us, bool disabled = false) const {
    const std::string folder = "cpu0/cpuidle/state" + std::to_string(state);
    Has({{folder + "/name", name},
         {folder + "/latency", std::to_string(latency_us)},
         {folder + "/disable", disabled ? "1" : "0"}});
  }
  void DmaLatency(std::int32_t latency_us) const {
    host.Write("/dev/cpu_dma_latency",
               std::string(reinterpret_cast<const char*>(&latency_us), sizeof latency_us));
  }
  MadeUpHost host;
};

TEST(CoreList, ReadsAndWritesTheKernelsWay) {
  EXPECT_THAT(ParseCores("0-2,5,7-8"), ElementsAre(0, 1, 2, 5, 7, 8));
  EXPECT_EQ(ToText({0, 1, 2, 5, 7, 8}), "0-2,5,7-8");
  EXPECT_TRUE(ParseCores("").empty());
  EXPECT_TRUE(ParseCores("(null)").empty()) << "as nohz_full says where there is none";
  EXPECT_LT(ParseCores("0-99999999999").size(), 10'000u);
}

TEST_F(Processor, WithOneCoreThatSavesPowerIsAWarning) {
  Has({{"online", "0-1"}});
  EXPECT_THAT(CheckGovernor(host.files), IsOk()) << "without frequencies";
  Has({{"cpu0/cpufreq/scaling_governor", "performance"},
       {"cpu1/cpufreq/scaling_governor", "performance"}});
  EXPECT_THAT(CheckGovernor(host.files), IsOk());
  Has({{"cpu1/cpufreq/scaling_governor", "powersave"}});
  EXPECT_THAT(CheckGovernor(host.files),
              IsWarning("performance, powersave", "cpupower frequency-set -g performance"));
}

TEST_F(Processor, ThatSleepsDeeplyIsAWarningUntilTheStateIsSwitchedOff) {
  Has({{"online", "0"}});
  EXPECT_THAT(CheckIdleStates(host.files), IsOk()) << "without states";
  IdleState(0, "POLL", 0);
  IdleState(1, "C1", 2);
  IdleState(2, "C6", 133);
  EXPECT_THAT(CheckIdleStates(host.files),
              IsWarning("C6, 133 us to leave", "cpupower idle-set -D 10"));
  IdleState(2, "C6", 133, true);
  EXPECT_THAT(CheckIdleStates(host.files), IsOk());
}

TEST_F(Processor, ThatAProgramKeepsAwakeIsFineHoweverDeepItCouldSleep) {
  Has({{"online", "0"}});
  IdleState(0, "C6", 133);
  DmaLatency(2'000'000'000);
  EXPECT_THAT(CheckIdleStates(host.files), IsWarning());
  DmaLatency(0);
  EXPECT_THAT(CheckIdleStates(host.files), IsOk());
}

TEST_F(Processor, NeedsAnIsolatedCoreWithoutTicks) {
  Has({{"online", "0-3"}, {"isolated", ""}});
  EXPECT_THAT(CheckIsolatedCores(host.files), IsWarning("none isolated", "isolcpus=3"));
  EXPECT_THAT(CheckIsolatedCores(host.files), IsWarning("", "--cpu 3"));
  Has({{"online", "0-7"}, {"isolated", "6-7"}, {"nohz_full", "  (null)"}});
  EXPECT_THAT(CheckIsolatedCores(host.files), IsWarning("", "nohz_full=6-7 rcu_nocbs=6-7"));
  Has({{"isolated", "7"}, {"nohz_full", "7"}});
  EXPECT_THAT(CheckIsolatedCores(host.files), IsOk("8 cores, 7 isolated"));
}

TEST_F(Processor, OfTwoCoresIsNotToldToGiveOneAway) {
  Has({{"online", "0-1"}});
  EXPECT_THAT(CheckIsolatedCores(host.files), IsWarning("2 cores: too few to reserve one"));
  EXPECT_THAT(CheckIsolatedCores(host.files).remedy, testing::Not(testing::HasSubstr("isolcpus")));
}

TEST_F(Processor, WithHyperThreadingIsAWarningUnlessACoreIsIsolatedWhole) {
  EXPECT_THAT(CheckHyperThreading(host.files), IsOk());
  Has({{"smt/active", "1"}});
  EXPECT_THAT(CheckHyperThreading(host.files), IsWarning());
  Has({{"isolated", "3"}, {"cpu3/topology/thread_siblings_list", "3,7"}});
  EXPECT_THAT(CheckHyperThreading(host.files), IsWarning()) << "half of it";
  Has({{"isolated", "3,7"}});
  EXPECT_THAT(CheckHyperThreading(host.files), IsOk());
}

}  // namespace
}  // namespace palpate::doctor
