#include "client/doctor/rights_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>

#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

using testing::HasSubstr;

constexpr int kPriority = 40;
constexpr const char* kNoCapabilities = "Name:\tx\nCapEff:\t0000000000000000\n";
constexpr const char* kNice = "Name:\tx\nCapEff:\t0000000000800000\n";

TEST(Scheduling, ThatIsGrantedIsFine) {
  MadeUpHost host;
  const Finding finding = CheckScheduling(host.files, {.fifo = true}, kPriority);
  EXPECT_EQ(finding.status, Status::kOk);
  EXPECT_EQ(finding.found, "SCHED_FIFO 40 is granted");
}

TEST(Scheduling, RefusedByTheLimitNamesTheFileAndTheGroup) {
  MadeUpHost host;
  host.Write("/proc/self/status", kNoCapabilities);
  const Finding finding = CheckScheduling(host.files, {.rtprio = 0}, kPriority);
  EXPECT_EQ(finding.status, Status::kFault);
  EXPECT_THAT(finding.found, HasSubstr("ulimit -r is 0, and CAP_SYS_NICE is missing"));
  EXPECT_THAT(finding.remedy, HasSubstr("/etc/security/limits.d/palpate.conf"));
  EXPECT_THAT(finding.remedy, HasSubstr("adduser $USER palpate"));
}

TEST(Scheduling, RefusedByItsControlGroupNamesTheGroupsFile) {
  for (const std::string where : {"/lab", ""}) {  // on the host, and in a container of the group
    MadeUpHost host;
    host.Write("/proc/self/status", kNice);
    host.Write("/proc/self/cgroup", "9:name=systemd:/lab\n1:cpu,cpuacct:/lab\n0::/\n");
    host.Write("/sys/fs/cgroup/cpu" + where + "/cpu.rt_runtime_us", "0\n");
    const Finding finding = CheckScheduling(host.files, {.rtprio = 0}, kPriority);
    EXPECT_EQ(finding.status, Status::kFault);
    EXPECT_THAT(finding.found, HasSubstr("has no real-time share"));
    EXPECT_THAT(finding.remedy, HasSubstr("/sys/fs/cgroup/cpu" + where + "/cpu.rt_runtime_us"));
  }
}

TEST(Scheduling, RefusedAgainstLimitsAndGroupsIsLaidToWhatRunsTheProcess) {
  MadeUpHost host;
  host.Write("/proc/self/status", kNoCapabilities);
  host.Write("/proc/self/cgroup", "0::/user.slice\n");
  const Finding finding = CheckScheduling(host.files, {.rtprio = std::nullopt}, kPriority);
  EXPECT_EQ(finding.status, Status::kFault);
  EXPECT_THAT(finding.remedy, HasSubstr("seccomp"));
  EXPECT_THAT(finding.remedy, HasSubstr("RestrictRealtime=no"));
}

TEST(LockedMemory, IsFineWhereItIsGrantedAndAWarningWithItsLimitWhereNot) {
  EXPECT_EQ(CheckLockedMemory({.memory_locked = true}).status, Status::kOk);
  const Finding finding = CheckLockedMemory({.memlock_kB = 8192});
  EXPECT_EQ(finding.status, Status::kWarning);
  EXPECT_THAT(finding.found, HasSubstr("ulimit -l is 8192 kB"));
  EXPECT_THAT(finding.remedy, HasSubstr("memlock unlimited"));
}

TEST(Throttling, IsANetThatShouldStayWhereItIs) {
  const auto check = [](const std::string& runtime_us) {
    MadeUpHost host;
    host.Write("/proc/sys/kernel/sched_rt_runtime_us", runtime_us + "\n");
    host.Write("/proc/sys/kernel/sched_rt_period_us", "1000000\n");
    return CheckThrottling(host.files);
  };
  EXPECT_EQ(check("950000").status, Status::kOk);
  EXPECT_EQ(check("-1").status, Status::kWarning);
  EXPECT_EQ(check("100000").status, Status::kWarning);
  EXPECT_EQ(check("0").status, Status::kFault);
  EXPECT_THAT(check("0").remedy, HasSubstr("sysctl kernel.sched_rt_runtime_us=950000"));
  MadeUpHost without;
  EXPECT_EQ(CheckThrottling(without.files).status, Status::kOk);
}

TEST(Rights, AreTriedWithoutLeavingThisThreadARealtimeOne) {
  TryRights({});
  EXPECT_EQ(sched_getscheduler(0), SCHED_OTHER);
}

}  // namespace
}  // namespace palpate::doctor
