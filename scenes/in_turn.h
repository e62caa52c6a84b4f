#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace palpate {

/// Makes things in threads and hands them over in turn.  Whoever takes them sees no difference from
/// making one after the other when he takes it: what a maker has to say, and what it throws, comes
/// at its turn, in the thread that takes.
template <class Thing>
class InTurn {
 public:
  using Event = std::function<void()>;
  /// Hands over what is to be called while the thing is being taken.  Throws, to end the making,
  /// where nobody will take the thing any more.
  using Say = std::function<void(Event)>;
  /// Called in any thread, with a number from 0.
  using Make = std::function<Thing(std::size_t, const Say&)>;

  /// @param threads  so many things are made at once, and as many may wait to be taken.  Where the
  ///                 system gives no thread at all, each thing is made when it is taken.
  InTurn(std::size_t count, std::size_t threads, Make make)
      : make_(std::move(make)), threads_wanted_(threads), end_(count), slots_(count) {
    try {
      while (threads_.size() < std::min(count, threads)) {
        threads_.emplace_back([this] {
          std::unique_lock lock(mutex_);
          while (MakeNext(lock)) {
          }
        });
      }
    } catch (const std::system_error&) {
      // Fewer will do.
    }
  }
  /// Waits for what is being made.
  ~InTurn() {
    {
      const std::lock_guard lock(mutex_);
      end_ = 0;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }
  InTurn(const InTurn&) = delete;
  InTurn& operator=(const InTurn&) = delete;

  /// The next thing.  Throws what its making threw: then nothing more is to be taken.
  Thing Take() {
    std::unique_lock lock(mutex_);
    Slot& slot = slots_[taken_];
    if (threads_.empty()) MakeNext(lock);
    for (;;) {
      changed_.wait(lock, [&] { return slot.done || !slot.said.empty(); });
      if (slot.said.empty()) break;
      const std::vector<Event> said = std::exchange(slot.said, {});
      lock.unlock();
      for (const Event& event : said) event();
      lock.lock();
    }
    if (slot.failed) std::rethrow_exception(slot.failed);
    ++taken_;
    changed_.notify_all();
    return std::move(*std::exchange(slot.made, std::nullopt));
  }

 private:
  struct Slot {
    std::vector<Event> said;
    std::optional<Thing> made;
    std::exception_ptr failed;
    bool done = false;
  };
  struct NobodyTakesIt {};

  /// False where there is no next.
  bool MakeNext(std::unique_lock<std::mutex>& lock) {
    changed_.wait(lock, [&] { return begun_ >= end_ || begun_ < taken_ + 2 * threads_wanted_; });
    if (begun_ >= end_) return false;
    const std::size_t number = begun_++;
    Slot& slot = slots_[number];
    const Say say = [&](Event event) {
      const std::lock_guard guard(mutex_);
      if (number >= end_) throw NobodyTakesIt();
      slot.said.push_back(std::move(event));
      changed_.notify_all();
    };
    lock.unlock();
    std::optional<Thing> made;
    std::exception_ptr failed;
    try {
      made = make_(number, say);
    } catch (...) {
      failed = std::current_exception();
    }
    lock.lock();
    slot.made = std::move(made);
    slot.failed = failed;
    slot.done = true;
    // What comes after a failure is not taken.
    if (failed) end_ = std::min(end_, number + 1);
    changed_.notify_all();
    return true;
  }

  const Make make_;
  const std::size_t threads_wanted_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t begun_ = 0, taken_ = 0;
  std::size_t end_;  ///< from here on nothing is taken
  std::vector<Slot> slots_;
  std::vector<std::thread> threads_;  // last: they use all of these
};

}  // namespace palpate
