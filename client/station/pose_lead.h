#pragma once

#include <array>
#include <cstdint>

#include "common/math/pose.h"

namespace palpate {

/// Predicts the hand's pose at the time when the reply arrives, for a distant server (README.md,
/// The lead): linear extrapolation by the velocity of the last poses.  Real-time.  Pure: time is an
/// argument; equal inputs give equal bits.
class PoseLead {
 public:
  /// A round trip of up to kNear_s has no lead; from kFar_s on the lead is its full length.
  static constexpr double kNear_s = 0.002;
  static constexpr double kFar_s = 0.004;
  static constexpr double kMost_s = 0.020;
  /// Added to the round trip, since a reply is held for a tick and blended in.
  static constexpr double kHeld_s = 0.0015;
  static constexpr double kMost_m = 0.003;
  static constexpr double kMost_rad = 0.05;
  /// Number of poses over which the velocity is taken: an encoder step of 30 um counts as 4 mm/s.
  static constexpr int kWindow = 8;
  /// Time constant of the mean round trip, in replies.
  static constexpr double kReplies = 50.0;

  /// Takes the round trip of a reply: time since its pose was sampled [s].
  void Hear(double round_trip_s) noexcept;
  /// Returns the predicted pose to send in place of X_WH.
  Pose Lead(std::int64_t now_ns, const Pose& X_WH) noexcept;
  /// Forgets earlier poses: later ones are unrelated to them.
  void Forget() noexcept { count_ = 0; }
  /// Returns the present lead [s].
  double lead_s() const noexcept;

 private:
  struct Seen {
    std::int64_t time_ns = 0;
    Pose X_WH;
  };
  std::array<Seen, kWindow> seen_;  // the last poses, as a ring
  std::uint64_t count_ = 0;
  double round_trip_s_ = 0.0;
};

}  // namespace palpate
