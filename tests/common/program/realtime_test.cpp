#include "common/program/realtime.h"

#include <functional>

#include <gmock/gmock.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/error.h"
#include "tests/support/complaint.h"
#include "tests/support/program.h"

namespace palpate {
namespace {

int CurrentPolicy() {
  return sched_getscheduler(0);
}

int CoresAllowed() {
  cpu_set_t cores;
  sched_getaffinity(0, sizeof cores, &cores);
  return CPU_COUNT(&cores);
}

int FirstCore() {
  cpu_set_t cores;
  sched_getaffinity(0, sizeof cores, &cores);
  int core = 0;
  while (!CPU_ISSET(core, &cores)) ++core;
  return core;
}

TEST(Realtime, ParsesItsModesAndNamesThemWhereThereIsNoSuch) {
  EXPECT_EQ(ParseRealtimeMode("require"), RealtimeMode::kRequire);
  EXPECT_EQ(ParseRealtimeMode("prefer"), RealtimeMode::kPrefer);
  EXPECT_EQ(ParseRealtimeMode("off"), RealtimeMode::kOff);
  EXPECT_EQ(test::ComplaintOf([] { ParseRealtimeMode("maybe"); }),
            "--realtime: 'maybe' is not known; give require, prefer or off");
}

TEST(Realtime, SaysWhatItObtainedAndObtainsWhatItSays) {
  const RealtimeReport report = EnterRealtime({.mode = RealtimeMode::kPrefer});
  EXPECT_EQ(CurrentPolicy(), report.fifo ? SCHED_FIFO : SCHED_OTHER);
  EXPECT_EQ(report.summary.find("no SCHED_FIFO") == std::string::npos, report.fifo);
  EXPECT_EQ(report.summary.find("not locked") == std::string::npos, report.memory_locked);
  LeaveRealtime();
  EXPECT_EQ(CurrentPolicy(), SCHED_OTHER);
}

TEST(Realtime, PinsAndUnpinsTheCallingThread) {
  const int before = CoresAllowed();
  const RealtimeReport report = EnterRealtime({.mode = RealtimeMode::kOff, .cpu = FirstCore()});
  EXPECT_TRUE(report.pinned);
  EXPECT_EQ(CoresAllowed(), 1);
  EXPECT_EQ(CurrentPolicy(), SCHED_OTHER);
  LeaveRealtime();
  EXPECT_EQ(CoresAllowed(), before);
}

TEST(Realtime, RefusesACoreThatDoesNotExist) {
  EXPECT_THROW(EnterRealtime({.mode = RealtimeMode::kOff, .cpu = 1000}), UsageError);
  EXPECT_THROW(EnterRealtime({.mode = RealtimeMode::kOff, .cpu = 100000}), UsageError);
}

/// Runs a check in a process that has given up root's rights, and with them its real-time limits.
bool HoldsWithoutRights(const std::function<bool()>& check) {
  const pid_t child = fork();
  if (child == 0) {
    if (setgid(65534) != 0 || setuid(65534) != 0) _exit(geteuid() == 0 ? 2 : 0);
    _exit(check() ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST(Realtime, NamesTheLimitAndTheRemedyWhereARequiredRightIsMissing) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, to give rights up";
  EXPECT_TRUE(HoldsWithoutRights([] {
    try {
      EnterRealtime({.mode = RealtimeMode::kRequire});
    } catch (const Error& e) {
      const std::string what = e.what();
      return what.find("ulimit -r is 0") != std::string::npos &&
             what.find("CAP_SYS_NICE") != std::string::npos &&
             what.find("limits.d") != std::string::npos && CurrentPolicy() == SCHED_OTHER;
    }
    return false;
  }));
}

TEST(Realtime, LeavesMemoryUnlockedWhereALimitWouldRefuseWhatIsAskedForLater) {
  test::Program process(PALPATE_BIN_DIR "/limited_process", {});
  EXPECT_EQ(process.Exit(), 0) << process.Output();
  EXPECT_THAT(process.Output(), testing::HasSubstr("memory not locked"));
  EXPECT_THAT(process.Output(), testing::HasSubstr("ulimit -l is 6291456"));
  EXPECT_THAT(process.Output(), testing::HasSubstr("memlock unlimited"));
}

TEST(Realtime, GoesOnWithoutAPreferredRight) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, to give rights up";
  EXPECT_TRUE(HoldsWithoutRights([] {
    const RealtimeReport report = EnterRealtime({.mode = RealtimeMode::kPrefer});
    return !report.fifo && report.summary.find("no SCHED_FIFO 40") != std::string::npos;
  }));
}

}  // namespace
}  // namespace palpate
