#pragma once

#include <cmath>

#include "common/math/pose.h"
#include "server/physics/haptic_model.h"
#include "server/physics/haptic_step.h"
#include "server/physics/limits.h"
#include "server/physics/step_state.h"

namespace palpate {

/// The graphic tool that follows one hand (the proxy, or god-object, of the literature): the haptic
/// step with the state and the buffers that it needs.
/// Thread contract: one thread at a time; models are shared by any number of proxies.
class Proxy {
 public:
  /// Puts the tool where the hand is, or at a free pose near it.  Not real-time: milliseconds.
  /// @param model  must outlive the proxy.
  /// @param X_WH   pose of the hand in W.
  /// Throws Error where that is not finite, or its quaternion is not of length 1.
  Proxy(const HapticModel& model, const Pose& X_WH);

  /// The same again, with all that was scraped off still gone.  Not real-time.
  void Restart(const Pose& X_WH);
  /// How far the tool was from the hand at the start [m]; 0 where the hand was free.  A hand that
  /// is deep inside an object should be led out before it is given forces.
  double start_depth() const { return start_depth_; }

  /// One cycle, to be called once for each new pose of the hand: 1 kHz, say (HapticStep).
  /// Real-time: no allocation, lock, log or clock.  Deterministic: equal poses, equal bits.
  /// @param X_WH   pose of the hand in W.
  /// @param times  where given, the stages are timed by a clock; the bits are the same.
  StepReport Step(const Pose& X_WH, StageTimes* times = nullptr) noexcept {
    return HapticStep(model_, Unit(X_WH), state_, workspace_, times);
  }

  const Pose& X_WG() const { return state_.X_WG; }
  const HapticModel& model() const { return model_; }
  /// All that the next step remembers: copied and put back, the same poses give the same bits.
  const StepState& state() const { return state_; }
  void set_state(const StepState& state) { state_ = state; }

 private:
  /// As the server takes poses in, so that its bits come out.
  static Pose Unit(Pose X) noexcept {
    const double norm2 = X.q.squaredNorm();
    if (norm2 > limits::kLeastSquaredNorm) X.q.coeffs() /= std::sqrt(norm2);
    return X;
  }

  const HapticModel& model_;
  StepWorkspace workspace_;
  StepState state_;
  double start_depth_ = 0.0;
};

}  // namespace palpate
