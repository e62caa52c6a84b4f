#pragma once

#include <cstdint>
#include <cstring>
#include <mutex>
#include <span>
#include <vector>

namespace palpate {

/// Samples on their way from the threads that receive them to the one that writes them: room for a
/// disk that stands still.  Memory is had at first and used when it is needed.
/// Thread contract: Put from any thread, Swap from one.
class SampleQueue {
 public:
  struct Head {
    std::int64_t time_ns;
    std::uint32_t channel;
    std::uint32_t size;
  };

  explicit SampleQueue(std::size_t capacity) : capacity_(capacity) { filling_.reserve(capacity); }

  /// False, keeping nothing, where there is no room.  Parts are put one behind the other.
  /// @param now_ns  called under the lock, so that times grow in the queue's order.
  template <class Clock>
  bool Put(std::uint32_t channel, Clock now_ns, std::span<const std::uint8_t> first,
           std::span<const std::uint8_t> second = {}) {
    const std::size_t size = first.size() + second.size();
    const std::lock_guard lock(mutex_);
    if (capacity_ - filling_.size() < sizeof(Head) + size) return false;
    const Head head{now_ns(), channel, static_cast<std::uint32_t>(size)};
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&head);
    filling_.insert(filling_.end(), bytes, bytes + sizeof head);
    filling_.insert(filling_.end(), first.begin(), first.end());
    filling_.insert(filling_.end(), second.begin(), second.end());
    return true;
  }

  /// Exchanges what has come for an empty buffer.
  void Swap(std::vector<std::uint8_t>& drained) {
    drained.clear();
    if (drained.capacity() < capacity_) drained.reserve(capacity_);
    const std::lock_guard lock(mutex_);
    drained.swap(filling_);
  }

  /// Calls visit(head, bytes) for each sample of a drained buffer, oldest first.
  template <class Visit>
  static void ForEach(const std::vector<std::uint8_t>& drained, Visit visit) {
    for (std::size_t at = 0; at < drained.size();) {
      Head head;
      std::memcpy(&head, &drained[at], sizeof head);
      at += sizeof head;
      visit(head, std::span<const std::uint8_t>(drained.data() + at, head.size));
      at += head.size;
    }
  }

 private:
  const std::size_t capacity_;
  std::mutex mutex_;
  std::vector<std::uint8_t> filling_;
};

}  // namespace palpate
