#pragma once

#include <array>
#include <atomic>
#include <cstddef>

#include "client/station/reply.h"

namespace palpate {

/// Replies on their way from DDS's receiving thread to the servo thread.  A ring and not a mailbox:
/// when two replies come within a tick, the older is late, not lost, and is counted so.
/// Thread contract: Push from one thread, Pop from one other, at the same time.
/// Real-time: wait-free on both sides, no allocation.
class ReplyRing {
 public:
  /// A quarter of a second at 1 kHz.
  static constexpr std::size_t kCapacity = 256;

  /// False, dropping the reply, where the servo thread has not read for that long: its device
  /// renders nothing then, whatever comes.
  bool Push(const Reply& reply) noexcept {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    // Acquire: what Pop has left is no longer being read.
    if (end - begin_.load(std::memory_order_acquire) == kCapacity) return false;
    replies_[end % kCapacity] = reply;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }

  /// Takes the oldest; false where there is none.
  bool Pop(Reply& reply) noexcept {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    // Acquire: the reply that Push announces is written.
    if (begin == end_.load(std::memory_order_acquire)) return false;
    reply = replies_[begin % kCapacity];
    begin_.store(begin + 1, std::memory_order_release);
    return true;
  }

 private:
  std::array<Reply, kCapacity> replies_{};
  alignas(64) std::atomic<std::size_t> begin_{0};
  alignas(64) std::atomic<std::size_t> end_{0};
};

}  // namespace palpate
