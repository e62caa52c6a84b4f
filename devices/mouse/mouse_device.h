#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "common/math/pose.h"
#include "common/realtime/latest_mailbox.h"
#include "devices/blind_hand.h"
#include "devices/device.h"

namespace palpate {

/// What a mouse's hand is told by a line of text.
struct MouseLine {
  std::optional<Pose> X_WT;  ///< where the tool is dragged to; none: it is let go
};

/// Reads `x y z qw qx qy qz` (metres; a rotation, which need not be of unit length; in W) or
/// `release`.  Nothing, with the reason, for anything else: not seven finite numbers, beyond 10 m,
/// or a quaternion without length.
std::optional<MouseLine> ParseMouseLine(std::string_view line, std::string& complaint);

/// A mouse, or whatever else writes such lines to a file descriptor: each says where the
/// tool is dragged to.  The person sees what happens and feels nothing.  When the lines end, so
/// does the device. Thread contract: as Device; a thread of its own reads the lines.
class MouseDevice final : public BlindDevice {
 public:
  /// Throws Error where no more files can be opened.
  /// @param lines  file descriptor, not closed here.
  /// @param start  where the tool is until the first line.
  MouseDevice(int lines, const Pose& start);
  ~MouseDevice() override;

  DeviceSample Read() noexcept override;
  bool ended() const noexcept override { return ended_.load(std::memory_order_acquire); }
  const char* activity() const noexcept override;

 private:
  struct Order {
    bool release = false;
    Pose X_WT;
  };
  void ReadLines();
  void TakeLine(std::string_view line);

  bool let_go_ = false;
  LatestMailbox<Order> orders_;
  std::atomic<bool> ended_{false};
  int bad_lines_ = 0;
  int lines_;
  int stop_;  // eventfd
  std::thread reader_;
};

}  // namespace palpate
