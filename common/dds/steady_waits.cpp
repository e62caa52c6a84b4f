// Makes the timed waits of third-party libraries use the steady clock.
//
// Cyclone DDS 0.10.2 waits for its next event, and iceoryx 2.0.3 for its next sign of life, until a
// time of the wall clock.  If that clock is set back by an hour, the wait takes an hour longer: the
// process no longer announces itself or answers those that do, requests no lost samples, and no
// lease ends; and RouDi takes a process without a sign of life for 1.5 s for dead, and frees its
// memory.  So the program defines these two functions itself, and the loader finds them before the
// C library's (the linker is told to export them, common/CMakeLists.txt): they compute once how
// long to wait, and wait by the clock that nobody sets.
//
// Rejected: detecting such a step and waking each library, because one of them offers no way to
// wake it.
#include <ctime>

#include <pthread.h>
#include <semaphore.h>

// ThreadSanitizer defines these functions itself, to track who waits for whom.
#ifndef __SANITIZE_THREAD__
namespace {

/// Times below this are of the steady clock, which counts from the host's start; a condition
/// variable does not tell which clock it uses.
constexpr std::time_t kSince1970_s = 1'000'000'000;

timespec Steady(const timespec& wall) noexcept {
  timespec wall_now{};
  timespec steady_now{};
  clock_gettime(CLOCK_REALTIME, &wall_now);
  clock_gettime(CLOCK_MONOTONIC, &steady_now);
  timespec steady{steady_now.tv_sec + (wall.tv_sec - wall_now.tv_sec),
                  steady_now.tv_nsec + (wall.tv_nsec - wall_now.tv_nsec)};
  for (; steady.tv_nsec < 0; steady.tv_nsec += 1'000'000'000) --steady.tv_sec;
  for (; steady.tv_nsec >= 1'000'000'000; steady.tv_nsec -= 1'000'000'000) ++steady.tv_sec;
  if (steady.tv_sec < 0) steady = {};  // long over
  return steady;
}

}  // namespace

extern "C" {

[[gnu::visibility("default")]] int pthread_cond_timedwait(pthread_cond_t* condition,
                                                          pthread_mutex_t* mutex,
                                                          const timespec* until) {
  const bool is_steady = until->tv_sec < kSince1970_s;
  const timespec steady = is_steady ? *until : Steady(*until);
  return pthread_cond_clockwait(condition, mutex, CLOCK_MONOTONIC, &steady);
}

[[gnu::visibility("default")]] int sem_timedwait(sem_t* semaphore, const timespec* until) {
  const timespec steady = Steady(*until);
  return sem_clockwait(semaphore, CLOCK_MONOTONIC, &steady);
}

}  // extern "C"
#endif
