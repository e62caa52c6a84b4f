#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace palpate {

/// A message for viewers, serialised once and shared by all of them.
struct Frame {
  std::uint32_t channel = 0;
  std::uint64_t origin = 0;    ///< the participant that wrote it (common/dds/cdr_reader.h)
  std::uint64_t instance = 0;  ///< identifies the key of its topic: a station, a scene, ...
  std::int64_t time_ns = 0;    ///< wall clock
  std::vector<std::uint8_t> payload;
  /// True if only the newest frame of the instance matters: one that it replaces is not
  /// counted as lost.
  bool state = false;
};
using FramePtr = std::shared_ptr<const Frame>;

/// The frames that wait for one viewer: only the newest of each channel and instance.  A stalled
/// viewer thus needs bounded memory, and gets current data when it reads again.  Instances are
/// served first come, first served.  Frames of channels without a subscription are dropped.
/// Thread contract: one thread.  Times are in nanoseconds.
class FrameQueue {
 public:
  /// @param period_ns  least time between two frames of an instance; frames in between are skipped.
  void Subscribe(std::uint32_t channel, std::uint32_t subscription, std::int64_t period_ns = 0);
  void Unsubscribe(std::uint32_t subscription);
  bool subscribed(std::uint32_t channel) const { return subscriptions_.contains(channel); }
  bool has_subscription(std::uint32_t subscription) const;

  void Push(const FramePtr& frame, std::int64_t now_ns);
  struct Next {
    FramePtr frame;  ///< null: nothing is due
    std::uint32_t subscription = 0;
  };
  Next Pop(std::int64_t now_ns);

  /// Number of frames that were due but replaced by newer ones, because the viewer was too slow.
  std::uint64_t lost() const { return lost_; }
  /// Number of waiting frames.
  std::size_t size() const { return due_.size() + early_.size(); }

 private:
  using Key = std::pair<std::uint32_t, std::uint64_t>;  // channel, instance
  struct Wanted {
    std::uint32_t subscription;
    std::int64_t period_ns;
  };
  struct Slot {
    FramePtr waiting;
    bool due = false;
    std::int64_t next_ns = 0;  // not due before
  };

  std::map<std::uint32_t, Wanted> subscriptions_;  // by channel
  std::map<Key, Slot> slots_;
  std::deque<Key> due_;
  std::vector<Key> early_;
  std::uint64_t lost_ = 0;
};

}  // namespace palpate
