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
/// Thread contract: one thread at a time; any number of proxies share a model.
class Proxy {
 public:
  /// Puts the tool where the hand is, or at a free pose near it.  Not real-time: milliseconds.
  /// @param model  must outlive the proxy
  /// @param X_WH   pose of the hand in W
  /// Throws Error if X_WH is not finite, or its quaternion is not of length 1.
  Proxy(const HapticModel& model, const Pose& X_WH);

  /// Puts the tool where a state says (state_bytes.h), which was of a proxy of the same model.
  Proxy(const HapticModel& model, const StepState& state, double start_depth)
      : model_(model), workspace_(model), state_(model), start_depth_(start_depth) {
    state_ = state;
  }

  /// Starts again from X_WH; material that was removed stays removed.  Not real-time.
  void Restart(const Pose& X_WH);
  /// Distance of the tool from the hand at the start [m]; 0 if the hand was free.  Lead a hand that
  /// is deep inside an object out before you give it forces.
  double start_depth() const { return start_depth_; }

  /// Runs one cycle; call it once for each new pose of the hand, for example at 1 kHz (HapticStep).
  /// Real-time: no allocation, lock, log or clock.  Deterministic: equal poses, equal bits.
  /// @param X_WH   pose of the hand in W
  /// @param times  if given, a clock times the stages; the bits are the same
  StepReport Step(const Pose& X_WH, StageTimes* times = nullptr) noexcept {
    return HapticStep(model_, Unit(X_WH), state_, workspace_, times);
  }

  const Pose& X_WG() const { return state_.X_WG; }
  /// Where a group of objects that moves is, relative to where its objects are placed.
  /// @param group  index in HapticModel::moved
  const Pose& X_moved(std::size_t group) const { return state_.frames.at(group + 1).X_WB; }
  const HapticModel& model() const { return model_; }
  /// All that the next step remembers.  If it is copied and restored, the same poses
  /// give the same bits.
  const StepState& state() const { return state_; }
  void set_state(const StepState& state) { state_ = state; }
  void set_state(const StepState& state, double start_depth) {
    state_ = state;
    start_depth_ = start_depth;
  }

 private:
  /// Normalises the quaternion as the server does, so that the bits are the server's.
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
