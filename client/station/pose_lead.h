#pragma once

#include <array>
#include <cstdint>

#include "common/math/pose.h"

namespace palpate {

/// Where the hand will be when the reply comes, for a server that is far away (README.md, The
/// lead): straight on, with the velocity of the last poses that were sent. Real-time.  Pure: time
/// comes in as an argument, equal inputs give equal bits.
class PoseLead {
 public:
  /// A round trip of up to the one has no lead, from the other on its whole length.
  static constexpr double kNear_s = 0.002;
  static constexpr double kFar_s = 0.004;
  static constexpr double kMost_s = 0.020;
  /// A reply is held for a tick, and blended in.
  static constexpr double kHeld_s = 0.0015;
  static constexpr double kMost_m = 0.003;
  static constexpr double kMost_rad = 0.05;
  /// Poses over which the velocity is taken: an encoder's step of 30 um counts as 4 mm/s.
  static constexpr int kWindow = 8;
  /// Time constant of the round trip's mean, in replies.
  static constexpr double kReplies = 50.0;

  /// A reply came, so long after its pose was sampled [s].
  void Hear(double round_trip_s) noexcept;
  /// For the next pose to be sent: it, as led.
  Pose Lead(std::int64_t now_ns, const Pose& X_WH) noexcept;
  /// Poses from here on have nothing to do with those before.
  void Forget() noexcept { count_ = 0; }
  /// [s]
  double lead_s() const noexcept;

 private:
  struct Seen {
    std::int64_t time_ns = 0;
    Pose X_WH;
  };
  std::array<Seen, kWindow> seen_;  // the last ones, in a ring
  std::uint64_t count_ = 0;
  double round_trip_s_ = 0.0;
};

}  // namespace palpate
