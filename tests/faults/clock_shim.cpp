// A library to preload into a program: the program's wall clock, and nothing else, then steps as a
// test says.  Covers reading CLOCK_REALTIME and waiting for a time of it: without the second, a
// wait until a time of the stepped clock would last an hour by the kernel's, which no step of a
// real clock causes.
#include "tests/faults/clock_shim.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <ctime>

#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

namespace {

using palpate::faults::SteppedClock;

constexpr std::int64_t kSecond_ns = 1'000'000'000;
/// How often a wait checks whether the clock has stepped, which a kernel's wait notices at once.
constexpr std::int64_t kLook_ns = 10'000'000;
/// Tells the clocks of a wait apart, as a condition variable does not say which it uses:
/// CLOCK_MONOTONIC counts from the host's start, and no host has run this long.
constexpr std::time_t kSince1970_s = 1'000'000'000;

SteppedClock* Map() {
  const char* const file = std::getenv(palpate::faults::kSteppedClockFile);
  if (file == nullptr) return nullptr;
  const int fd = open(file, O_RDWR | O_CLOEXEC);
  if (fd < 0) return nullptr;
  void* const place =
      mmap(nullptr, sizeof(SteppedClock), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  close(fd);
  return place == MAP_FAILED ? nullptr : static_cast<SteppedClock*>(place);
}

// Set once before main; programs that ask for the time even earlier get the true one.
SteppedClock* stepped = nullptr;
using ClockGetTime = int (*)(clockid_t, timespec*);
ClockGetTime next_clock_gettime = nullptr;

__attribute__((constructor)) void Begin() {
  next_clock_gettime = reinterpret_cast<ClockGetTime>(dlsym(RTLD_NEXT, "clock_gettime"));
  stepped = Map();
}

std::int64_t AheadNs() {
  return stepped == nullptr ? 0 : stepped->ahead_ns.load(std::memory_order_relaxed);
}

std::int64_t ToNs(const timespec& time) {
  return static_cast<std::int64_t>(time.tv_sec) * kSecond_ns + time.tv_nsec;
}
timespec ToTime(std::int64_t ns) {
  return {static_cast<std::time_t>(ns / kSecond_ns), static_cast<long>(ns % kSecond_ns)};
}

int RightTime(clockid_t clock, timespec* time) {
  if (next_clock_gettime != nullptr) return next_clock_gettime(clock, time);
  return static_cast<int>(syscall(SYS_clock_gettime, clock, time));
}

std::int64_t WallNs() {
  timespec time{};
  clock_gettime(CLOCK_REALTIME, &time);
  return ToNs(time);
}

/// Waits by the stepped clock as a kernel does by its own.
/// @param wait  waits until a time of the steady clock; returns an errno, or 0.
template <class Wait>
int WaitUntil(const timespec& until, const Wait& wait) {
  for (;;) {
    const std::int64_t left_ns = ToNs(until) - WallNs();
    timespec right{};
    RightTime(CLOCK_MONOTONIC, &right);
    const timespec look = ToTime(ToNs(right) + std::clamp<std::int64_t>(left_ns, 0, kLook_ns));
    const int result = wait(look);
    if (result != ETIMEDOUT || left_ns <= 0) return result;
  }
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* time) {
  const int result = RightTime(clock, time);
  if (result != 0 || (clock != CLOCK_REALTIME && clock != CLOCK_REALTIME_COARSE)) return result;
  if (const std::int64_t ahead_ns = AheadNs(); ahead_ns != 0) {
    *time = ToTime(ToNs(*time) + ahead_ns);
    stepped->asked.fetch_add(1, std::memory_order_relaxed);
  }
  return 0;
}

int gettimeofday(timeval* time, void* zone) {
  if (zone != nullptr) *static_cast<struct timezone*>(zone) = {};
  const timespec now = ToTime(WallNs());
  *time = {now.tv_sec, now.tv_nsec / 1000};
  return 0;
}

std::time_t time(std::time_t* time) {
  const std::time_t now = WallNs() / kSecond_ns;
  if (time != nullptr) *time = now;
  return now;
}

int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                           const timespec* until) {
  if (until->tv_sec < kSince1970_s) {
    return pthread_cond_clockwait(condition, mutex, CLOCK_MONOTONIC, until);
  }
  return WaitUntil(*until, [&](const timespec& look) {
    return pthread_cond_clockwait(condition, mutex, CLOCK_MONOTONIC, &look);
  });
}

int sem_timedwait(sem_t* semaphore, const timespec* until) {
  const int error = WaitUntil(*until, [&](const timespec& look) {
    return sem_clockwait(semaphore, CLOCK_MONOTONIC, &look) == 0 ? 0 : errno;
  });
  errno = error;
  return error == 0 ? 0 : -1;
}

}  // extern "C"
