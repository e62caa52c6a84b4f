#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

#include "common/dds/wire.h"
#include "common/realtime/latest_mailbox.h"

namespace palpate {

/// Answers the poses of one session in a thread of its own, with a priority below all servo
/// threads. It is for mice, whose hand feels nothing, so that late answers do no harm.  Of the
/// poses that come during an answer, or while the thread rests for its share, only the newest is
/// answered; the others are dropped, as if the network had lost them.
class BackgroundServo {
 public:
  /// Share of a core for each mouse.
  static constexpr double kShare = 0.1;

  /// @param answer  called in the thread for each pose that is answered; must not throw
  explicit BackgroundServo(std::function<void(const wire::HapticPose&)> answer);
  /// Returns once no pose is being answered.
  ~BackgroundServo();
  BackgroundServo(const BackgroundServo&) = delete;
  BackgroundServo& operator=(const BackgroundServo&) = delete;

  /// Passes on a pose.  Call from one thread.  Real-time: no allocation, lock or wait; it
  /// wakes the other thread.
  void Give(const wire::HapticPose& pose) noexcept;

 private:
  void Run();

  std::function<void(const wire::HapticPose&)> answer_;
  LatestMailbox<wire::HapticPose> poses_;
  std::atomic<std::uint32_t> given_{0};
  std::atomic<bool> stop_{false};
  std::thread thread_;  // last, because it uses all other members
};

}  // namespace palpate
