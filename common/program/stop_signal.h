#pragma once

#include <chrono>

namespace palpate {

/// Turns every signal by which a user or a limit ends a program into a flag on which a main loop
/// can wait: SIGINT (Ctrl-C), SIGQUIT, SIGTERM (which RouDi also sends when it ends), SIGHUP (the
/// terminal was closed), SIGPIPE (the reader of the output has gone, as after a lost ssh without a
/// terminal) and SIGXCPU (ulimit -t).  SIGXFSZ (ulimit -f) is ignored, so that a write fails.
/// A SIGINT, SIGQUIT or SIGTERM that comes again, more than 0.2 s after its first, kills the
/// process at once.  SIGHUP, SIGPIPE and SIGXCPU stay ignored if they were (`nohup`).  After the
/// first signal, output may fail.  One object per process, made by main.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  bool stopped() const noexcept;
  /// Sleeps for the duration, or until a signal comes.  Returns stopped().
  bool WaitFor(std::chrono::nanoseconds duration) noexcept;
};

/// Returns whether a signal has told the process's StopSignal to end, if there is one.
bool StopWasSignalled() noexcept;

/// Ignores Ctrl-Z and what else suspends a job of a terminal: an arm would keep its last force
/// while its process is suspended.
void StayAwake() noexcept;

}  // namespace palpate
