#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <type_traits>

namespace palpate {

/// A queue of at most N values from one thread to another.
/// Thread contract: Push from one thread, Pop from one other, at the same time.
/// Real-time: wait-free on both sides, no allocation.
template <class T, std::size_t N>
class Ring {
  static_assert(std::is_trivially_destructible_v<T>, "a value that owns memory would free it late");

 public:
  static constexpr std::size_t kCapacity = N;

  /// Appends a value; if the queue is full, drops the value and returns false.
  bool Push(const T& value) noexcept {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    // Acquire: the slot that Pop has freed is no longer being read.
    if (end - begin_.load(std::memory_order_acquire) == N) return false;
    values_[end % N] = value;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }

  /// For the pushing thread: true if a Push now might drop its value; false if it will not.
  bool full() const noexcept { return size() == N; }

  /// Returns the number of values: a lower bound for the popping thread, an upper bound for the
  /// pushing one.
  std::size_t size() const noexcept {
    const std::size_t begin = begin_.load(std::memory_order_acquire);
    return end_.load(std::memory_order_acquire) - begin;
  }

  /// For the popping thread: the oldest value, to be read in place until Drop().  Requires size()
  /// > 0.
  const T& Front() const noexcept { return values_[begin_.load(std::memory_order_relaxed) % N]; }
  void Drop() noexcept {
    begin_.store(begin_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

  /// Takes the oldest value; false if there is none.
  bool Pop(T& value) noexcept {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    // Acquire: the value that Push announces is written.
    if (begin == end_.load(std::memory_order_acquire)) return false;
    value = values_[begin % N];
    begin_.store(begin + 1, std::memory_order_release);
    return true;
  }

 private:
  std::array<T, N> values_{};
  alignas(64) std::atomic<std::size_t> begin_{0};
  alignas(64) std::atomic<std::size_t> end_{0};
};

}  // namespace palpate
