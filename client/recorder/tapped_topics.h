#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>

#include "common/recording/recorded_type.h"

namespace palpate {

/// A topic that is recorded.
struct TappedTopic {
  std::string name;
  RecordedType type;
  std::atomic<std::uint64_t> dropped{0};  ///< came, and had no room in the queue
};

/// The topics that are recorded, by the numbers that samples in the queue have.  A number is given
/// once and stays.
/// Thread contract: any.
class TappedTopics {
 public:
  /// The number of the topic of that name, which is entered where it is new.
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
  std::deque<TappedTopic> topics_;  // stays where it is as it grows
  std::map<std::string, std::uint32_t> numbers_;
};

}  // namespace palpate
