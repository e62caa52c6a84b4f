#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace palpate {

/// A message for viewers: serialised once, shared by all of them.
struct Frame {
  std::uint32_t channel = 0;
  std::uint64_t origin = 0;    ///< the participant that wrote it (common/dds/cdr_reader.h)
  std::uint64_t instance = 0;  ///< of its topic's key: a station, a scene, ...
  std::int64_t time_ns = 0;    ///< wall clock
  std::vector<std::uint8_t> payload;
  /// False where a newer frame of the instance makes this one worthless; true where its viewer
  /// must in the end have the newest, which then is no loss.
  bool state = false;
};
using FramePtr = std::shared_ptr<const Frame>;

/// What waits for one viewer: of each channel and instance the newest frame and no more, so that a
/// viewer that stalls has bounded memory, and newest things when it is back.  First come, first
/// served among instances.  Holds only channels that are subscribed to.
/// Thread contract: one thread.  Time is given [ns].
class FrameQueue {
 public:
  /// @param period_ns  least time between two frames of an instance; those between are passed over.
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

  /// Frames that were due and that newer ones have taken the place of: the viewer was too slow.
  std::uint64_t lost() const { return lost_; }
  /// Frames that wait.
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
    std::int64_t next_ns = 0;  // not before
  };

  std::map<std::uint32_t, Wanted> subscriptions_;  // by channel
  std::map<Key, Slot> slots_;
  std::deque<Key> due_;
  std::vector<Key> early_;
  std::uint64_t lost_ = 0;
};

}  // namespace palpate
