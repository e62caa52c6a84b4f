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
  struct Taken {
    int signal;
    bool once;  // a second one kills a program that does not end by the first
    bool may_be_ignored;
  };
  // The end of a terminal sends SIGHUP several times, by the shell and by the kernel; each write
  // without a reader sends SIGPIPE.  `nohup` asks a program to go on without its terminal, and the
  // caller of a pipe may ask for it, too.  But shells start each background job of a script with
  // SIGINT and SIGQUIT ignored: `kill -INT`, sent to that job by name, is meant for it.
  for (const Taken& taken :
       {Taken{SIGHUP, false, true}, Taken{SIGPIPE, false, true}, Taken{SIGINT, true, false},
        Taken{SIGQUIT, true, false}, Taken{SIGTERM, true, false}}) {
    struct sigaction action {};
    if (taken.may_be_ignored && sigaction(taken.signal, nullptr, &action) == 0 &&
        action.sa_handler == SIG_IGN) {
      continue;
    }
    action.sa_handler = handler;
    action.sa_flags = SA_RESTART | (taken.once ? static_cast<int>(SA_RESETHAND) : 0);
    sigaction(taken.signal, &action, nullptr);
  }
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

void StayAwake() noexcept {
  for (const int signal : {SIGTSTP, SIGTTIN, SIGTTOU}) std::signal(signal, SIG_IGN);
}

}  // namespace palpate
