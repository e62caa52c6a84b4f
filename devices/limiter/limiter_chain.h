#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "devices/limiter/energy_stage.h"
#include "devices/limiter/stages.h"
#include "devices/limiter/wrench_limits.h"

namespace palpate {

/// The limiter's input, once per tick.  It may contain any values whatever: one that is out of its
/// range leads to no more force than the worst value in it.
struct LimiterInput {
  Wrench wanted;  ///< contact wrench at the handle, in W
  Wrench led;  ///< what a guide or an effect adds that is active by design: it has a bound of its
               ///< own, and is not in the energy balance
  Pose X_WH;   ///< pose of the handle as just measured
  Twist V_WH;  ///< the driver's value; no stage relies on it
  double silence_s = std::numeric_limits<double>::infinity();  ///< AgeStage
  double age_s = std::numeric_limits<double>::infinity();      ///< AgeStage
  double dt_s = 0.0;      ///< since the last call; NaN, infinite, negative: counts as no reply
  bool entering = false;  ///< the hand was inside already: `wanted` grows by the server's ramp
  /// DeviceSample::motor_temperature.
  double motor_temperature = std::numeric_limits<double>::quiet_NaN();
};

/// The number of calls in which each stage acted; `fades` counts events.
struct LimiterCounts {
  std::uint64_t calls = 0;
  std::uint64_t nonfinite = 0;
  std::uint64_t clamped = 0;
  std::uint64_t slewed = 0;
  std::uint64_t braked = 0;          ///< reduced by the energy stage
  std::uint64_t warm = 0;            ///< reduced by the temperature stage
  std::uint64_t faded = 0;           ///< calls with less than the whole wrench because of age
  std::uint64_t fades = 0;           ///< number of times that replies stopped after they had begun
  std::uint64_t disabled = 0;        ///< calls with less than the whole wrench because of enable
  std::uint64_t too_hot = 0;         ///< calls with a motor temperature above 1
  std::uint64_t too_cold = 0;        ///< calls with a negative one
  std::uint64_t no_temperature = 0;  ///< calls without one (NaN)
};

/// Returns what a user must know of the motor temperatures that a device has reported, with the
/// remedy; empty: nothing.
std::string TemperatureRemark(const LimiterCounts& counts);

/// The longest time that a tick counts for: after a stall the next step is no larger than one of
/// 2 ms.
inline constexpr double kMaxTick_s = 0.002;
/// The shortest time of a tick; anything less counts as zero.
inline constexpr double kMinTick_s = 1e-6;

/// Returns whether a time between two calls is one.
inline bool IsTick(double dt_s) noexcept {
  return dt_s >= 0.0 && dt_s <= std::numeric_limits<double>::max();
}
/// Returns the time that a call counts for; if it is none, the longest, for what takes force away.
inline double CountedTick(double dt_s) noexcept {
  if (!IsTick(dt_s)) return kMaxTick_s;
  return dt_s >= kMinTick_s ? std::min(dt_s, kMaxTick_s) : 0.0;
}

/// The stages of a limiter in order; WrenchLimiter (wrench_limiter.h) describes them and proves
/// their bounds.  The output is a plain Wrench, which no device accepts.
/// @tparam Energy  EnergyStage, or a replacement for measurements.
/// Real-time: no allocation, lock, log or clock.
template <class Energy>
class LimiterChain {
 public:
  explicit LimiterChain(const WrenchLimits& limits)
      : limits_(limits),
        clamp_(limits.force_N(), limits.torque_Nm()),
        slew_(limits.rates().contact_force, limits.rates().contact_torque),
        energy_(limits),
        led_clamp_(limits.bounds().led_force_N, limits.bounds().led_torque_Nm),
        led_slew_(limits.rates().led_force, limits.rates().led_torque),
        temperature_({limits.force_N(), limits.continuous_force_N(), limits.thermal_time_s()},
                     {limits.torque_Nm(), limits.continuous_torque_Nm(), limits.thermal_time_s()}) {
  }

  Wrench Limit(const LimiterInput& in) noexcept {
    ++calls_;
    CountTemperature(in.motor_temperature);
    // A time that is none raises nothing, and the wrench fades as without a reply.
    const bool is_tick = IsTick(in.dt_s);
    const double counted = CountedTick(in.dt_s), dt = is_tick ? counted : 0.0;
    const double silence_s = is_tick ? in.silence_s : std::numeric_limits<double>::infinity();
    // Depends on time alone; computed here because the energy stage must know what the later stages
    // will leave.
    const double gain =
        age_.Gain(silence_s, in.age_s, counted) * enable_.Gain(enable_.enabled() ? dt : counted);
    // If the last wrench was not rendered, a jump from it cannot be felt, so the slew stage need
    // not start from the force of a server that died.
    const bool felt = gain_ > 0.0;

    const Wrench slewed = slew_.Pass(clamp_.Pass(finite_.Pass(in.wanted)), dt, felt);
    // True for a hand that is in contact when the ramp begins; one that touches later puts in its
    // own energy.
    const bool pressed = !slewed.force.isZero(0.0) || !slewed.torque.isZero(0.0);
    entering_ = gain > gain_ && (entering_ || (!felt && pressed));
    gain_ = gain;
    const Wrench contact = energy_.Pass(slewed, gain, in.X_WH, dt, felt, entering_ || in.entering);
    // Nobody knows where a hand that cannot be seen is led to.
    const Wrench guide = energy_.observer().seen() ? in.led : Wrench{};
    const Wrench led = led_slew_.Pass(led_clamp_.Pass(finite_.Pass(guide)), dt, felt);

    const Wrench both{contact.force + led.force, contact.torque + led.torque};
    const TemperatureStage::Share share = temperature_.Pass(both, in.motor_temperature, counted);
    const double force = gain * share.force, torque = gain * share.torque;
    energy_.Hold({force * contact.force, torque * contact.torque});
    const Wrench applied{force * both.force, torque * both.torque};
    temperature_.Give(applied, counted);
    return applied;
  }

  void Enable(bool on) noexcept { enable_.Enable(on); }
  bool enabled() const noexcept { return enable_.enabled(); }
  bool fading() const noexcept { return age_.fading(); }

  LimiterCounts counts() const noexcept {
    return {calls_,
            finite_.count(),
            clamp_.count() + led_clamp_.count(),
            slew_.count() + led_slew_.count(),
            energy_.count(),
            temperature_.count(),
            age_.count(),
            age_.fades(),
            enable_.count(),
            too_hot_,
            too_cold_,
            no_temperature_};
  }
  Energy& energy() noexcept { return energy_; }
  const Energy& energy() const noexcept { return energy_; }
  const TemperatureStage& temperature() const noexcept { return temperature_; }
  const WrenchLimits& limits() const noexcept { return limits_; }

 private:
  void CountTemperature(double temperature) noexcept {
    too_hot_ += temperature > 1.0;
    too_cold_ += temperature < 0.0;
    no_temperature_ += std::isnan(temperature);
  }

  WrenchLimits limits_;
  FiniteStage finite_;
  ClampStage clamp_;
  SlewStage slew_;
  Energy energy_;
  ClampStage led_clamp_;
  SlewStage led_slew_;
  TemperatureStage temperature_;
  AgeStage age_;
  EnableStage enable_;
  double gain_ = 0.0;      // of the previous call
  bool entering_ = false;  // the gain is growing from zero, and the hand was in contact when
                           // that began
  std::uint64_t calls_ = 0;
  std::uint64_t too_hot_ = 0, too_cold_ = 0, no_temperature_ = 0;
};

}  // namespace palpate
