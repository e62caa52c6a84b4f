#pragma once

#include <cstdint>

#include "common/math/pose.h"
#include "devices/openhaptics/hd_error.h"

namespace palpate {

/// Whether an arm's motors get what the limiter let through.  Below the limiter, as an error of the
/// arm takes its force away within one frame, where the limiter would ramp out:
///   calibrating  closed until Open()
///   paused       closed until 0.1 s without an error have passed *and* the limiter asks for
///                nothing at all: as a closed gate is a fault to the station, the limiter gets
///                there by itself, and the force comes back by its ramp, never by a step
///   cooling      motors are hot: closed until all are below kCool and 2 s have passed, or 60 s
///                where no temperature can be read; then paused
///   latched      closed for good
/// Counts ticks, reads no clock.  Real-time.  Not thread-safe: the tick's thread owns it.
class OutputGate {
 public:
  enum class State { kCalibrating, kPaused, kOn, kCooling, kLatched };
  static constexpr double kQuiet_s = 0.1;
  static constexpr double kLeastRest_s = 2.0;
  static constexpr double kBlindRest_s = 60.0;
  /// Of HD_MOTOR_TEMPERATURE, which is 1 where the library calls them warm.  An estimate: low
  /// enough that the next contact is not the next error.
  static constexpr double kCool = 0.7;

  explicit OutputGate(double rate_Hz) : rate_Hz_(rate_Hz) {}

  /// The arm is calibrated.
  void Open() noexcept;
  void Report(hd::ErrorClass error) noexcept;
  /// Of the hottest motor; never called: none can be read.
  void SetTemperature(double hottest) noexcept;
  /// Once per tick: whether this wrench may go out.
  bool Passes(const Wrench& limited) noexcept;

  State state() const noexcept { return state_; }
  /// Whether the motors are to be on at all, HD_FORCE_OUTPUT.
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
