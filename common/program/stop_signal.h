#pragma once

#include <chrono>

namespace palpate {

/// Ctrl-C and SIGTERM (which RouDi too sends when it ends) as a flag that a main loop waits on.  A
/// second signal of the same kind kills at once.  One object per process, made by main.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  bool stopped() const noexcept;
  /// Sleeps, but no longer than until a signal comes.  Returns stopped().
  bool WaitFor(std::chrono::nanoseconds duration) noexcept;
};

}  // namespace palpate
