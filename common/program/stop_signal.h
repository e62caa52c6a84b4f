#pragma once

#include <chrono>

namespace palpate {

/// Turns Ctrl-C and SIGTERM (which RouDi also sends when it ends) into a flag on which a main loop
/// can wait.  A second signal of the same kind kills the process at once.  One object per process,
/// made by main.
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

}  // namespace palpate
