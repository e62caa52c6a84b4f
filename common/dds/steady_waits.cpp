// Timed waits of other people's libraries, by the steady clock.
//
// Cyclone DDS 0.10.2 waits for its next event, and iceoryx 2.0.3 for its next sign of life, until a
// time of the wall clock.  Where that is set back an hour, the wait lasts an hour longer: the
// process announces itself no more and answers nobody who does, nothing lost is asked for again, no
// lease ends; and RouDi takes a process that gives no sign of life for 1.5 s for dead, and its
// memory from it.  So these two functions are the program's own, which the loader finds before the
// C library's (the linker is told to show them, common/CMakeLists.txt): what is left until that
// time is read once, and waited for by the clock that nobody sets.
//
// Rejected: to look for steps and wake each library: one offers nothing to be woken by.
#include <ctime>

#include <pthread.h>
#include <semaphore.h>

// ThreadSanitizer has these names for itself, to see who waits for whom.
#ifndef __SANITIZE_THREAD__
namespace {

/// A condition variable does not tell which clock it waits by.  The steady one counts from the
/// host's start, and is not that old.
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
