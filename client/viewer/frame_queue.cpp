#include "client/viewer/frame_queue.h"

#include <algorithm>

namespace palpate {

void FrameQueue::Subscribe(std::uint32_t channel, std::uint32_t subscription,
                           std::int64_t period_ns) {
  subscriptions_[channel] = {subscription, period_ns};
}

bool FrameQueue::has_subscription(std::uint32_t subscription) const {
  return std::ranges::any_of(
      subscriptions_, [&](const auto& entry) { return entry.second.subscription == subscription; });
}

void FrameQueue::Unsubscribe(std::uint32_t subscription) {
  const auto found = std::ranges::find_if(
      subscriptions_, [&](const auto& entry) { return entry.second.subscription == subscription; });
  if (found == subscriptions_.end()) return;
  const std::uint32_t channel = found->first;
  subscriptions_.erase(found);
  const auto of_channel = [&](const Key& key) { return key.first == channel; };
  std::erase_if(slots_, [&](const auto& entry) { return of_channel(entry.first); });
  std::erase_if(due_, of_channel);
  std::erase_if(early_, of_channel);
}

void FrameQueue::Push(const FramePtr& frame, std::int64_t now_ns) {
  if (!subscriptions_.contains(frame->channel)) return;
  const Key key{frame->channel, frame->instance};
  Slot& slot = slots_[key];
  if (slot.waiting) {
    lost_ += slot.due && !slot.waiting->state;
  } else {
    slot.due = now_ns >= slot.next_ns;
    if (slot.due) {
      due_.push_back(key);
    } else {
      early_.push_back(key);
    }
  }
  slot.waiting = frame;
}

FrameQueue::Next FrameQueue::Pop(std::int64_t now_ns) {
  std::erase_if(early_, [&](const Key& key) {
    Slot& slot = slots_[key];
    slot.due = now_ns >= slot.next_ns;
    if (slot.due) due_.push_back(key);
    return slot.due;
  });
  if (due_.empty()) return {};
  const Key key = due_.front();
  due_.pop_front();
  const auto slot = slots_.find(key);
  const Wanted& wanted = subscriptions_.at(key.first);
  Next next{std::move(slot->second.waiting), wanted.subscription};
  if (wanted.period_ns == 0) {
    slots_.erase(slot);
  } else {
    // In whole periods: otherwise the arrival times of the frames would lower the rate.
    slot->second = {nullptr, false,
                    std::max(slot->second.next_ns + wanted.period_ns, now_ns - wanted.period_ns)};
  }
  return next;
}

}  // namespace palpate
