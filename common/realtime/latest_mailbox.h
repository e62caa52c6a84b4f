#pragma once

#include <atomic>
#include <cstdint>
#include <type_traits>

namespace palpate {

/// Passes the latest value from one thread to another; values that are not read in time are
/// overwritten.  Triple buffer: the writer owns one, the reader owns one, the third is exchanged.
/// Thread contract: Write from one thread, Read from one thread; they may run at the same time.
/// Real-time: wait-free on both sides, no allocation.
template <class T>
class LatestMailbox {
  static_assert(std::is_trivially_destructible_v<T>, "a value that owns memory would allocate");

 public:
  void Write(const T& value) noexcept {
    buffer_[writer_] = value;
    // Release: the reader that takes this buffer sees its content.  Acquire: the buffer that comes
    // back is no longer being read.
    writer_ = middle_.exchange(writer_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }

  /// Takes the latest value; false, with `value` unchanged, if none came since the last Read.
  bool Read(T& value) noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    reader_ = middle_.exchange(reader_, std::memory_order_acq_rel) & kIndex;
    value = buffer_[reader_];
    return true;
  }

 private:
  static constexpr std::uint8_t kIndex = 3;
  static constexpr std::uint8_t kFresh = 4;

  T buffer_[3]{};
  alignas(64) std::atomic<std::uint8_t> middle_{1};
  alignas(64) std::uint8_t writer_ = 0;
  alignas(64) std::uint8_t reader_ = 2;
};

}  // namespace palpate
