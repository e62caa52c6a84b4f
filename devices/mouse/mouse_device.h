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

/// A command to the mouse's hand, from a line of text.
struct MouseLine {
  std::optional<Pose> X_WT;  ///< pose to which the tool is dragged; none: release
  bool still = false;        ///< a bur stands still there
};

/// Parses `x y z qw qx qy qz` (metres; a quaternion of any length but zero; in W), after which
/// `still` may stand, or `release`.  Returns nothing, with the reason, for anything else: not seven
/// finite numbers, a position beyond 10 m, or a zero quaternion.
std::optional<MouseLine> ParseMouseLine(std::string_view line, std::string& complaint);

/// A mouse, or anything else that writes such lines to a file descriptor: each is a pose to which
/// the tool is dragged.  The user sees what happens but feels nothing.  The device ends when the
/// lines end. Thread contract: as Device; a thread of its own reads the lines.
class MouseDevice final : public BlindDevice {
 public:
  /// Throws Error if no more files can be opened.
  /// @param lines  file descriptor, not closed here.
  /// @param start  pose of the tool until the first line.
  MouseDevice(int lines, const Pose& start);
  ~MouseDevice() override;

  DeviceSample Read() noexcept override;
  bool ended() const noexcept override { return ended_.load(std::memory_order_acquire); }
  const char* activity() const noexcept override;

 private:
  struct Order {
    bool release = false, still = false;
    Pose X_WT;
  };
  void ReadLines();
  void TakeLine(std::string_view line);

  bool let_go_ = false;
  std::uint32_t buttons_ = 0;
  LatestMailbox<Order> orders_;
  std::atomic<bool> ended_{false};
  int bad_lines_ = 0;
  int lines_;
  int stop_;  // eventfd
  std::thread reader_;
};

}  // namespace palpate
