#include "common/program/stop_signal.h"

#include <atomic>
#include <cerrno>
#include <csignal>

#include <semaphore.h>
#include <time.h>

#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

/// Signals of one wish come within this time: `timeout` sends one to its command and one to the
/// command's group, and a wrapper passes on the Ctrl-C that its terminal has sent to both.
constexpr std::int64_t kOneWish_ns = 200'000'000;

// The data that the signal handler uses: lock-free, and a semaphore.
std::atomic<bool> stop{false};
std::atomic<std::int64_t> first_ns[NSIG];  // when each came first; 0: it has not
sem_t wake;
static_assert(std::atomic<bool>::is_always_lock_free &&
              std::atomic<std::int64_t>::is_always_lock_free);

void OnSignal(int) {
  const int saved = errno;
  stop.store(true);
  sem_post(&wake);
  errno = saved;
}

void OnSignalThatKills(int signal) {
  const int saved = errno;
  const std::int64_t now_ns = SteadyNanoseconds();
  std::int64_t first = 0;
  if (!first_ns[signal].compare_exchange_strong(first, now_ns) && now_ns - first > kOneWish_ns) {
    std::signal(signal, SIG_DFL);
    raise(signal);  // once this handler has returned
  }
  OnSignal(signal);
  errno = saved;
}

struct Handlers {
  void (*stops)(int);
  void (*kills)(int);  // a second one kills a program that does not end by the first
};

void Install(const Handlers& handlers) {
  struct Taken {
    int signal;
    void (*Handlers::*handler)(int);
    bool may_be_ignored;
  };
  // The end of a terminal sends SIGHUP several times, by the shell and by the kernel; each write
  // without a reader sends SIGPIPE.  `nohup` asks a program to go on without its terminal, and the
  // caller of a pipe may ask for it, too.  But shells start each background job of a script with
  // SIGINT and SIGQUIT ignored: `kill -INT`, sent to that job by name, is meant for it.
  for (const Taken& taken :
       {Taken{SIGHUP, &Handlers::stops, true}, Taken{SIGPIPE, &Handlers::stops, true},
        Taken{SIGXCPU, &Handlers::stops, true}, Taken{SIGINT, &Handlers::kills, false},
        Taken{SIGQUIT, &Handlers::kills, false}, Taken{SIGTERM, &Handlers::kills, false}}) {
    struct sigaction action {};
    if (taken.may_be_ignored && sigaction(taken.signal, nullptr, &action) == 0 &&
        action.sa_handler == SIG_IGN) {
      continue;
    }
    action.sa_handler = handlers.*taken.handler;
    action.sa_flags = SA_RESTART;
    sigaction(taken.signal, &action, nullptr);
  }
}

}  // namespace

StopSignal::StopSignal() {
  stop.store(false);
  for (auto& first : first_ns) first.store(0);
  sem_init(&wake, 0, 0);
  Install({OnSignal, OnSignalThatKills});
  // A file at its size limit (ulimit -f) then fails as a write error, like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
}

StopSignal::~StopSignal() {
  Install({SIG_DFL, SIG_DFL});
  stop.store(false);
  sem_destroy(&wake);
}

bool StopSignal::stopped() const noexcept {
  return StopWasSignalled();
}

bool StopWasSignalled() noexcept {
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
