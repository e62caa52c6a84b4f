#pragma once

#include <atomic>
#include <cstddef>
#include <type_traits>
#include <vector>

namespace palpate {

/// A list that one thread appends to while others read it: what is in it stays as it is.
/// Thread contract: Append from one thread; size and [] from any, at the same time.
/// Real-time: wait-free on both sides; memory for `capacity` values is allocated at first.
template <class T>
class AppendLog {
  static_assert(std::is_trivially_copyable_v<T>, "a value that owns memory would allocate");

 public:
  explicit AppendLog(std::size_t capacity) : values_(capacity) {}

  /// False, and nothing appended, where it is full.
  bool Append(const T& value) noexcept {
    const std::size_t n = size_.load(std::memory_order_relaxed);
    if (n == values_.size()) return false;
    values_[n] = value;
    // Release: who sees the new size sees the value.
    size_.store(n + 1, std::memory_order_release);
    return true;
  }
  std::size_t size() const noexcept { return size_.load(std::memory_order_acquire); }
  /// i < size(), as this thread has read it.
  const T& operator[](std::size_t i) const noexcept { return values_[i]; }

 private:
  std::vector<T> values_;
  std::atomic<std::size_t> size_{0};
};

}  // namespace palpate
