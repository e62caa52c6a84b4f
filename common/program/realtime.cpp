#include "common/program/realtime.h"

#include <cerrno>
#include <cstring>

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include "common/error.h"

namespace palpate {
namespace {

// The cores on which this thread could run before it was pinned.
thread_local cpu_set_t cores_before;
thread_local bool pinned_before = false;

std::string LimitText(__rlimit_resource_t resource) {
  rlimit limit{};
  getrlimit(resource, &limit);
  return limit.rlim_cur == RLIM_INFINITY ? "unlimited" : std::to_string(limit.rlim_cur);
}

std::string WhyNoFifo(int priority, int error) {
  if (error != EPERM) return std::string("no SCHED_FIFO (") + std::strerror(error) + ")";
  return "no SCHED_FIFO " + std::to_string(priority) + " (ulimit -r is " +
         LimitText(RLIMIT_RTPRIO) +
         " and CAP_SYS_NICE or the cgroup's cpu.rt_runtime_us is missing: put '* - rtprio 95' in "
         "/etc/security/limits.d and log in again, or 'setcap cap_sys_nice,cap_ipc_lock+ep' on the "
         "program; in docker, and in podman that root runs, --cap-add SYS_NICE --ulimit rtprio=95; "
         "in podman without root the host's limits count: raise them there, log in again, and run "
         "it with --ulimit host)";
}

std::string WhyNoLock(int error) {
  return std::string("memory not locked (") + std::strerror(error) + ", ulimit -l is " +
         LimitText(RLIMIT_MEMLOCK) +
         ": put '* - memlock unlimited' in /etc/security/limits.d and log in again, or give "
         "CAP_IPC_LOCK)";
}

/// Whether the kernel holds a process whose future memory is locked to its limit.  Asked of it, and
/// not of the process's capabilities, which do not count for it in a user namespace.
bool LimitBindsFutureMemory() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  if (limit.rlim_cur == RLIM_INFINITY) return false;
  const std::size_t beyond = limit.rlim_cur + 1;
  // Inaccessible and locked only once touched, so it costs nothing.
  void* const probe =
      mmap(nullptr, beyond, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (probe == MAP_FAILED) return errno == EAGAIN;
  munmap(probe, beyond);
  return false;
}

/// Locks the memory; returns 0 or the error.  All or nothing: under a limit, later requests for
/// memory would be refused, and that would end the process (bad_alloc, a stack that cannot grow)
/// while a hand is on the device.
int LockMemory() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) return errno;
  if (!LimitBindsFutureMemory()) return 0;
  munlockall();
  return EAGAIN;
}

/// Touches the stack page by page, so that the loop causes no page faults there.
[[gnu::noinline]] void PrefaultStack() {
  volatile char stack[256 * 1024];
  for (std::size_t i = 0; i < sizeof stack; i += 4096) stack[i] = 0;
}

void Add(std::string& list, const std::string& item) {
  if (!list.empty()) list += ", ";
  list += item;
}

}  // namespace

RealtimeMode ParseRealtimeMode(const std::string& text) {
  if (text == "require") return RealtimeMode::kRequire;
  if (text == "prefer") return RealtimeMode::kPrefer;
  if (text == "off") return RealtimeMode::kOff;
  throw UsageError("--realtime: '" + text + "' is not known; give require, prefer or off");
}

RealtimeReport EnterRealtime(const RealtimeOptions& options) {
  RealtimeReport report;
  std::string missing;

  if (options.cpu >= 0) {
    cpu_set_t allowed;
    cpu_set_t wanted;
    CPU_ZERO(&allowed);
    CPU_ZERO(&wanted);
    sched_getaffinity(0, sizeof allowed, &allowed);
    if (options.cpu >= CPU_SETSIZE || !CPU_ISSET(options.cpu, &allowed)) {
      throw UsageError(
          "--cpu " + std::to_string(options.cpu) +
          ": this process may not run on that core; 'taskset -p $$' shows the permitted ones");
    }
    CPU_SET(options.cpu, &wanted);
    report.pinned = sched_setaffinity(0, sizeof wanted, &wanted) == 0;
    cores_before = allowed;
    pinned_before = report.pinned;
  }

  if (options.mode != RealtimeMode::kOff) {
    sched_param parameters{};
    parameters.sched_priority = options.priority;
    const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
    report.fifo = error == 0;
    if (error != 0) Add(missing, WhyNoFifo(options.priority, error));

    const int lock_error = LockMemory();
    report.memory_locked = lock_error == 0;
    if (lock_error != 0) Add(missing, WhyNoLock(lock_error));
    PrefaultStack();
  }
  if (options.mode == RealtimeMode::kRequire && !missing.empty()) {
    LeaveRealtime();
    throw Error("--realtime require: " + missing + ", or give --realtime prefer");
  }

  if (report.fifo) Add(report.summary, "SCHED_FIFO " + std::to_string(options.priority));
  if (report.memory_locked) Add(report.summary, "memory locked");
  if (report.pinned) Add(report.summary, "core " + std::to_string(options.cpu));
  if (!missing.empty()) Add(report.summary, missing);
  if (report.summary.empty()) report.summary = "not real-time (as asked)";
  return report;
}

void LeaveRealtime() {
  sched_param parameters{};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &parameters);
  if (pinned_before) sched_setaffinity(0, sizeof cores_before, &cores_before);
  pinned_before = false;
}

}  // namespace palpate
