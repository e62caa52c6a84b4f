#pragma once

#include <cstdint>
#include <mutex>

#include "client/python/held_wrench.h"
#include "common/math/pose.h"
#include "common/realtime/latest_mailbox.h"
#include "devices/device.h"

namespace palpate {

/// What a PosedDevice was given in a tick.  Wrenches act at the handle's origin, in W.
struct Felt {
  std::uint64_t move = 0;       ///< newest one whose end the hand has reached; 0: none yet
  std::int64_t arrived_ns = 0;  ///< when that was, by the steady clock
  Pose X_WH;                    ///< the hand, as it was read in this tick
  Twist V_WH;                   ///< of the move
  Pose X_WG;                    ///< the graphic tool, at the newest reply
  bool sees_tool = false;       ///< X_WG is known
  Wrench wanted;                ///< before the limiter
  Wrench applied;               ///< what the limiter let through
};

/// A hand that goes where a program says, tick by tick and at bounded speed, and rests there.  No
/// motor moves it; the limiter's figures are those that it is made with.
/// Thread contract: as Device; Go, felt and Lead from any other threads.
class PosedDevice final : public Device {
 public:
  static constexpr double kTick_s = 1e-3;

  /// @param start  where the hand is until it is moved.
  /// @param max_force_N, max_torque_Nm  peak and continuous figures of the data sheet.
  PosedDevice(const Pose& start, double max_force_N, double max_torque_Nm);

  /// Moves the hand from where it is, straight and at one speed, whatever moved it before.  It
  /// takes longer than `seconds` where the hand would be faster than BlindHand's bounds.
  /// @param X_WT  finite, its quaternion of length 1.
  /// Returns the move's number, from 1.
  std::uint64_t Go(const Pose& X_WT, double seconds);
  /// Of the newest tick.
  Felt felt();
  /// Leads the hand by that until there is another, where one comes in time: four times as late as
  /// it should, and 50 ms at least, it leads no more.
  void Lead(const HeldWrench& held);

  const DeviceInfo& info() const override { return info_; }
  DeviceSample Read() noexcept override;
  void Apply(const LimitedWrench& wrench) noexcept override;
  void Shape(Wrench& contact, Wrench& led) noexcept override;
  void SeeGraphicTool(const Pose& X_WG, const Vec3& p_HT) noexcept override;
  void LoseGraphicTool() noexcept override { now_.sees_tool = false; }

 private:
  struct Move {
    std::uint64_t number = 0;
    Pose X_WT;
    double seconds = 0.0;
  };
  void Begin(const Move& move) noexcept;

  DeviceInfo info_;
  std::mutex callers_;  // of those who move and look, never of the servo thread
  std::uint64_t moves_ = 0;
  LatestMailbox<Move> orders_;
  LatestMailbox<HeldWrench> leads_;
  LatestMailbox<Felt> felt_;
  Felt newest_;  // read from felt_

  // The servo thread's.
  Felt now_;
  Move move_;
  Vec3 v_ = Vec3::Zero();    // of the move under way, in W
  Vec3 phi_ = Vec3::Zero();  // its rotation vector, in W
  Pose X_W0_;                // where it began
  int ticks_ = 0;            // that it takes
  int tick_ = 0;
  HeldWrench held_;
  std::uint64_t held_ticks_ = 0;  // that it leads the hand yet
};

}  // namespace palpate
