#pragma once

#include <optional>

#include "devices/device.h"
#include "devices/simulated/phantom_sheets.h"
#include "devices/simulated/simulated_hand.h"

namespace palpate {

namespace test {
class PastTheLimiter;  // tests/support: for measurements of what the limiter does
}

/// A haptic device that exists only here: a rigid handle with mass, friction, motors that saturate,
/// encoders that quantise and a workspace that ends, held by a simulated hand or by none.
/// Each Apply lets one period of its rate pass, in sub-steps of at most kSubstep_s (semi-implicit
/// Euler; friction implicit, so that it stops a handle and never drives it); so its time is a
/// count, and a run repeats to the bit. The mechanism is balanced: no gravity.
class SimulatedPhantom final : public Device {
 public:
  static constexpr double kSubstep_s = 0.125e-3;
  static constexpr double kMaxRate_Hz = 4000.0;

  /// @param hand  none: the handle floats free from X_WH on.
  /// Throws Error where the sheet's rate is not within 100 Hz to kMaxRate_Hz.
  SimulatedPhantom(const PhantomSheet& sheet, std::optional<SimulatedHand> hand, const Pose& X_WH);

  const DeviceInfo& info() const override { return info_; }
  /// The pose as the encoders give it, and its velocity as a driver estimates it from them.
  DeviceSample Read() noexcept override;
  void Apply(const LimitedWrench& wrench) noexcept override;
  const char* activity() const noexcept override;

  // The truth behind the encoders, for tests and displays.
  const Pose& pose() const noexcept { return X_WH_; }
  const Twist& velocity() const noexcept { return V_WH_; }
  double time() const noexcept { return tick_s_ * static_cast<double>(ticks_); }
  double kinetic_energy_J() const noexcept;

 private:
  friend class test::PastTheLimiter;
  /// The tick that Apply lets pass, under any wrench.
  void Pass(const Wrench& commanded) noexcept;
  Pose Encoded() const noexcept;
  Wrench MotorWrench(const Wrench& commanded) const noexcept;
  void Substep(const Wrench& motor, double t, double h) noexcept;

  DeviceInfo info_;
  HandleDynamics dynamics_;
  double tick_s_;
  int substeps_;
  double velocity_share_;  // of a new encoder difference in the estimate
  std::optional<SimulatedHand> hand_;
  double mass_;     // handle and hand [kg]
  double inertia_;  // [kg m^2]
  Pose X_WH_;
  Twist V_WH_;
  long long ticks_ = 0;
  Pose encoded_;       // at the last Apply
  Twist estimated_V_;  // from encoder differences
};

}  // namespace palpate
