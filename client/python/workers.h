#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace palpate {

/// Threads that share the calls of a loop, kept from one loop to the next.  Which thread makes
/// which call depends on their speed. Thread contract: one thread at a time calls Run.  A child
/// that a process forks while nothing runs begins threads of its own.
class Workers {
 public:
  /// @param threads  in all, with the one that calls Run; at least 1.  The others begin with Run.
  explicit Workers(int threads);
  ~Workers();
  int threads() const { return threads_; }

  /// @param index  of the call   @param thread  which makes it, from 0: that which called Run
  using Work = std::function<void(std::size_t index, std::size_t thread)>;
  /// Calls work for each index below `count`, and returns when all calls have returned.  After a
  /// call throws no other begins, and Run throws that.
  /// @param wait  called every few milliseconds while only others work; what it throws ends the
  /// loop,
  ///              as if it were thrown by a call
  void Run(
      std::size_t count, const Work& work, const std::function<void()>& wait = [] {});
  /// Returns whether a call has failed in this loop: long calls look, and return early.
  bool has_failed() const;

 private:
  struct Shared;
  /// Ends the threads, unless they are those of the process that this one was forked from.
  void End();

  int threads_;
  std::unique_ptr<Shared> shared_;
};

}  // namespace palpate
