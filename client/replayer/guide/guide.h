#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "client/replayer/playback.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// The progress of a guide along its path: at the recorded pace while the hand keeps up, slower the
/// further the hand lags behind, and stopped from kFar_m on until it comes.  Otherwise the aim
/// would run away from a hand that resists, and a station stops pulling towards an aim that stays
/// out of reach.
/// Pure: time is an argument.
class GuidePace {
 public:
  /// Up to this distance the station's spring force grows (Guide::kReach_m); beyond it, the hand
  /// has fallen behind.
  static constexpr double kNear_m = 0.005;
  static constexpr double kFar_m = 3.0 * kNear_m;

  /// @param rate  factor on the recorded pace.   @param waits  false: never slows down.
  GuidePace(double rate, double from_s, bool waits) : rate_(rate), waits_(waits), time_s_(from_s) {}

  /// @param behind_m  distance from hand to aim; none: the hand's pose is not known.
  void Advance(double dt_s, std::optional<double> behind_m) {
    const double share =
        waits_ && behind_m ? std::clamp((kFar_m - *behind_m) / (kFar_m - kNear_m), 0.0, 1.0) : 1.0;
    if (share == 0.0) waiting_ = true;
    if (share > 0.5) waiting_ = false;
    time_s_ += rate_ * share * dt_s;
  }
  double time_s() const { return time_s_; }
  /// True while the guide has stopped because the hand is too far behind, and until it moves at
  /// half its pace again.
  bool waiting() const { return waiting_; }

 private:
  double rate_;
  bool waits_;
  double time_s_;
  bool waiting_ = false;
};

struct GuideOptions {
  std::string led;      ///< station to be guided
  std::string station;  ///< as SessionChoice: the session whose path guides it
  bool waits = true;    ///< for a hand that lags behind
};

/// Leads the hand of a station along the recorded hand's path, at the recorded pace times a rate,
/// until the path's end or a signal; waits for a hand that lags behind (GuidePace).  The station
/// decides the force, and whether to accept a guide at all.  Throws Error if the recording holds
/// no path, or if no station accepts a guide within some seconds.
void Guide(const Playback& playback, const GuideOptions& options, StopSignal& stop);

}  // namespace palpate
