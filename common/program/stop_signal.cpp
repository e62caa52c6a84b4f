#include "common/program/stop_signal.h"

#include <atomic>
#include <cerrno>
#include <csignal>

#include <semaphore.h>
#include <time.h>

namespace palpate {
namespace {

// The data that the signal handler uses: a lock-free flag and a semaphore.
std::atomic<bool> stop{false};
sem_t wake;
static_assert(std::atomic<bool>::is_always_lock_free);

void OnSignal(int) {
  const int saved = errno;
  stop.store(true);
  sem_post(&wake);
  errno = saved;
}

void Install(void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = static_cast<int>(SA_RESTART | SA_RESETHAND);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

}  // namespace

StopSignal::StopSignal() {
  stop.store(false);
  sem_init(&wake, 0, 0);
  Install(OnSignal);
}

StopSignal::~StopSignal() {
  Install(SIG_DFL);
  sem_destroy(&wake);
}

bool StopSignal::stopped() const noexcept {
  return stop.load();
}

bool StopSignal::WaitFor(std::chrono::nanoseconds duration) noexcept {
  constexpr long kSecond = 1'000'000'000;
  timespec until;
  clock_gettime(CLOCK_MONOTONIC, &until);
  until.tv_sec += duration.count() / kSecond;
  until.tv_nsec += duration.count() % kSecond;
  if (until.tv_nsec >= kSecond) {
    until.tv_nsec -= kSecond;
    ++until.tv_sec;
  }
  while (!stopped() && sem_clockwait(&wake, CLOCK_MONOTONIC, &until) != 0 && errno == EINTR) {
  }
  return stopped();
}

}  // namespace palpate
