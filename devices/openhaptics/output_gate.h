#pragma once

#include <cstdint>

#include "common/math/pose.h"
#include "devices/openhaptics/hd_error.h"

namespace palpate {

/// A gate between the limiter and an arm's motors.  It is behind the limiter because an error of
/// the arm removes its force within one frame, while the limiter would ramp it out:
///   calibrating  closed until Open()
///   paused       closed until 0.1 s have passed without an error *and* the limiter's output is
///                zero; the station treats a closed gate as a fault, so the limiter goes to zero by
///                itself, and the force returns by its ramp and never by a step
///   cooling      motors are hot: closed until all are below kCool and 2 s have passed, or for 60 s
///                if no temperature can be read; then paused
///   latched      closed for ever
/// Counts ticks, reads no clock.  Real-time.  Not thread-safe: the tick's thread owns it.
class OutputGate {
 public:
  enum class State { kCalibrating, kPaused, kOn, kCooling, kLatched };
  static constexpr double kQuiet_s = 0.1;
  static constexpr double kLeastRest_s = 2.0;
  static constexpr double kBlindRest_s = 60.0;
  /// Value of HD_MOTOR_TEMPERATURE, which is 1 when the library reports warm motors.  An estimate:
  /// low enough that the next contact does not cause the next error.
  static constexpr double kCool = 0.7;

  explicit OutputGate(double rate_Hz) : rate_Hz_(rate_Hz) {}

  /// Opens the gate's calibrating state once the arm is calibrated.
  void Open() noexcept;
  void Report(hd::ErrorClass error) noexcept;
  /// Sets the temperature of the hottest motor.  Never called if none can be read.
  void SetTemperature(double hottest) noexcept;
  /// Returns whether this wrench may be rendered.  Call it once per tick.
  bool Passes(const Wrench& limited) noexcept;

  State state() const noexcept { return state_; }
  /// Returns whether the motors are to be switched on (HD_FORCE_OUTPUT).
  bool motors_on() const noexcept { return state_ == State::kOn || state_ == State::kPaused; }

 private:
  bool Rested(double seconds) const noexcept {
    return static_cast<double>(quiet_ticks_) >= seconds * rate_Hz_;
  }
  void Enter(State state) noexcept;

  double rate_Hz_;
  State state_ = State::kCalibrating;
  std::uint64_t quiet_ticks_ = 0;  // since the state was entered or an error came
  double hottest_ = 0.0;
  bool knows_temperature_ = false;
};

}  // namespace palpate
