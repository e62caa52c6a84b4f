#pragma once

#include <atomic>
#include <thread>

#include "common/realtime/latest_mailbox.h"
#include "devices/blind_hand.h"
#include "devices/device.h"

namespace palpate {

/// A mouse, or whatever else writes lines (mouse_line.h) to a file descriptor: each says where the
/// tool is dragged to.  The person sees what happens and feels nothing.  When the lines end, so
/// does the device. Thread contract: as Device; a thread of its own reads the lines.
class MouseDevice final : public Device {
 public:
  static constexpr double kTick_s = 1e-3;

  /// Throws Error where no more files can be opened.
  /// @param lines  file descriptor, not closed here.
  /// @param start  where the tool is until the first line.
  MouseDevice(int lines, const Pose& start);
  ~MouseDevice() override;

  const DeviceInfo& info() const override { return info_; }
  DeviceSample Read() noexcept override;
  void Apply(const LimitedWrench& wrench) noexcept override;
  void SeeGraphicTool(const Pose& X_WG, const Vec3& p_HT) noexcept override {
    hand_.SeeGraphicTool(X_WG, p_HT);
  }
  void LoseGraphicTool() noexcept override { hand_.LoseGraphicTool(); }
  bool ended() const noexcept override { return ended_.load(std::memory_order_acquire); }
  const char* activity() const noexcept override;

 private:
  struct Order {
    bool release = false;
    Pose X_WT;
  };
  void ReadLines();
  void TakeLine(std::string_view line);

  DeviceInfo info_;
  BlindHand hand_;
  bool let_go_ = false;
  LatestMailbox<Order> orders_;
  std::atomic<bool> ended_{false};
  int bad_lines_ = 0;
  int lines_;
  int stop_;  // eventfd
  std::thread reader_;
};

}  // namespace palpate
