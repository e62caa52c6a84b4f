#pragma once

#include <cstdint>
#include <mutex>

#include "client/python/held_wrench.h"
#include "common/math/pose.h"
#include "common/realtime/latest_mailbox.h"
#include "devices/device.h"

namespace palpate {

/// The readings of a PosedDevice in one tick.  Wrenches act at the handle's origin, in W.
struct Felt {
  std::uint64_t move = 0;       ///< newest move whose end the hand has reached; 0: none yet
  std::int64_t arrived_ns = 0;  ///< when it did, by the steady clock
  Pose X_WH;                    ///< the hand's pose read in this tick
  Twist V_WH;                   ///< of the move
  Pose X_WG;                    ///< the graphic tool, at the newest reply
  bool sees_tool = false;       ///< X_WG is known
  Wrench wanted;                ///< before the limiter
  Wrench applied;               ///< what the limiter let through
};

/// A simulated hand that a program moves: it goes to the given poses tick by tick at bounded speed,
/// and rests there.  It has no motors; the limiter gets the figures passed to the constructor.
/// Thread contract: as Device; Go, felt and Lead from any other threads.
class PosedDevice final : public Device {
 public:
  static constexpr double kTick_s = 1e-3;

  /// @param start  the hand's pose until its first move.
  /// @param max_force_N, max_torque_Nm  peak and continuous figures, as in a data sheet.
  PosedDevice(const Pose& start, double max_force_N, double max_torque_Nm);

  /// Moves the hand from its present pose in a straight line at constant speed, replacing any
  /// earlier move.  The move takes longer than `seconds` if the hand would exceed BlindHand's
  /// speed bounds.
  /// @param X_WT  finite, its quaternion of length 1.
  /// Returns the move's number, from 1.
  std::uint64_t Go(const Pose& X_WT, double seconds);
  /// Returns the newest tick's readings.
  Felt felt();
  /// Leads the hand with that wrench until the next call.  Without one, the wrench ends after four
  /// periods of HeldWrench::every, and after 50 ms at least.
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
  std::mutex callers_;  // among callers that move and read; the servo thread never takes it
  std::uint64_t moves_ = 0;
  LatestMailbox<Move> orders_;
  LatestMailbox<HeldWrench> leads_;
  LatestMailbox<Felt> felt_;
  Felt newest_;  // latest value read from felt_

  // Used by the servo thread only.
  Felt now_;
  Move move_;
  Vec3 v_ = Vec3::Zero();    // of the move under way, in W
  Vec3 phi_ = Vec3::Zero();  // its rotation vector, in W
  Pose X_W0_;                // where the move began
  int ticks_ = 0;            // duration of the move
  int tick_ = 0;
  HeldWrench held_;
  std::uint64_t held_ticks_ = 0;  // remaining ticks in which held_ acts
};

}  // namespace palpate
