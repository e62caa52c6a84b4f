#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "client/replayer/playback.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// How far along its path a guide is: at the recorded pace while the hand keeps up, slower the
/// further it lags behind, and at rest from kFar_m on, until it comes.  Else the aim would run away
/// from a hand that resists, and a station lets go of an aim that is out of reach.
/// Pure: time comes in as an argument.
class GuidePace {
 public:
  /// Up to here the station's spring grows (Guide::kReach_m); beyond, the hand has fallen behind.
  static constexpr double kNear_m = 0.005;
  static constexpr double kFar_m = 3.0 * kNear_m;

  /// @param rate  times the recorded pace.   @param waits  false: never slower.
  GuidePace(double rate, double from_s, bool waits) : rate_(rate), waits_(waits), time_s_(from_s) {}

  /// @param behind_m  from the hand to the aim; none: nobody knows where the hand is.
  void Advance(double dt_s, std::optional<double> behind_m) {
    const double share =
        waits_ && behind_m ? std::clamp((kFar_m - *behind_m) / (kFar_m - kNear_m), 0.0, 1.0) : 1.0;
    if (share == 0.0) waiting_ = true;
    if (share > 0.5) waiting_ = false;
    time_s_ += rate_ * share * dt_s;
  }
  double time_s() const { return time_s_; }
  /// At rest, for the hand is too far behind, or only just begun again.
  bool waiting() const { return waiting_; }

 private:
  double rate_;
  bool waits_;
  double time_s_;
  bool waiting_ = false;
};

struct GuideOptions {
  std::string led;      ///< station to be guided
  std::string station;  ///< whose path guides it, as SessionChoice
  bool waits = true;    ///< for a hand that stays behind
};

/// Leads the hand of a station along the recorded hand's path, at the recorded pace times a rate,
/// until its end or a signal; waits where the hand stays behind (GuidePace).  The station
/// decides with how much force, and whether at all.  Throws Error where the recording holds no
/// path.
void Guide(const Playback& playback, const GuideOptions& options, StopSignal& stop);

}  // namespace palpate
