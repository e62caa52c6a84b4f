#include "client/doctor/rights_checks.h"

#include <sched.h>

#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

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
  for (const std::string where : {"/lab", ""}) {  // on the host, and in a container of the group
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

}  // namespace
}  // namespace palpate::doctor
