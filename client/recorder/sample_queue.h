#pragma once

#include <atomic>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "common/recording/recorded_type.h"

namespace palpate {

/// A recorded topic.
struct TappedTopic {
  std::string name;
  RecordedType type;
  std::atomic<std::uint64_t> dropped{0};  ///< samples lost because the queue was full
};

/// The recorded topics by number, as samples in the queue refer to them.  A number never changes.
/// Thread contract: any.
class TappedTopics {
 public:
  /// Returns the number of the topic of that name; adds the topic if it is new.
  std::uint32_t NumberOf(const std::string& name, RecordedType type) {
    const std::lock_guard lock(mutex_);
    const auto [it, is_new] =
        numbers_.try_emplace(name, static_cast<std::uint32_t>(topics_.size()));
    if (is_new) {
      TappedTopic& topic = topics_.emplace_back();
      topic.name = name;
      topic.type = type;
    }
    return it->second;
  }
  TappedTopic& operator[](std::uint32_t number) {
    const std::lock_guard lock(mutex_);
    return topics_[number];
  }
  std::uint32_t size() const {
    const std::lock_guard lock(mutex_);
    return static_cast<std::uint32_t>(topics_.size());
  }

 private:
  mutable std::mutex mutex_;
  std::deque<TappedTopic> topics_;  // a deque: elements stay in place as it grows
  std::map<std::string, std::uint32_t> numbers_;
};

/// A queue of samples from the threads that receive them to the thread that writes them; it buffers
/// while the disk stalls.  Memory is reserved at construction and touched when first used.
/// Thread contract: Put from any thread, Swap from one.
class SampleQueue {
 public:
  struct Head {
    std::int64_t time_ns;
    std::uint32_t channel;
    std::uint32_t size;
  };

  explicit SampleQueue(std::size_t capacity) : capacity_(capacity) { filling_.reserve(capacity); }

  /// Appends a sample of both parts, one after the other.  Returns false, storing nothing, if there
  /// is no room.
  /// @param now_ns  called under the lock, so that times increase in queue order.
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

  /// Swaps the queued samples with an empty buffer.
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
