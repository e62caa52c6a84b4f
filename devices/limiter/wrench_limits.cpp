#include "devices/limiter/wrench_limits.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/error.h"
#include "devices/limiter/age_stage.h"
#include "devices/limiter/enable_stage.h"
#include "devices/limiter/temperature_stage.h"

namespace palpate {
namespace {

/// The whole peak in 5 ms.
constexpr double kWholePeak_ms = 5.0;
/// As much as a guide may ask for (client/station/guide.h), whatever the device could do.
constexpr double kLedForce_N = 1.0;
constexpr double kLedTorque_Nm = 0.01;
constexpr double kNoTorque_Nm = 1e-9;
/// What a guide adds comes and goes within this time: it never hurries.
constexpr double kLedWhole_s = 0.02;
/// Rounding in the sums of the proof, some 1e-15 of the peak, beside a step of 1 us.
constexpr double kRounding = 1.0 - 1e-6;

void CheckPositive(double value, const char* name) {
  if (value > 0.0 && std::isfinite(value)) return;
  throw Error(std::string("wrench limits: ") + name + " is " + std::to_string(value) +
              "; it must be positive and finite (does the device's info() give its peak and "
              "continuous force and torque?)");
}

}  // namespace

WrenchLimits::Rates WrenchLimits::rates() const noexcept {
  // |d(a e y)| <= |dy| + |y| (|da| + |de|), and y itself moves with contact, guide and temperature.
  const double factors =
      AgeStage::kFastest_1_s + EnableStage::kFastest_1_s + TemperatureStage::kFastest_1_s;
  Rates rates;
  rates.led_force = bounds_.led_force_N / kLedWhole_s;
  rates.led_torque = bounds_.led_torque_Nm / kLedWhole_s;
  rates.contact_force =
      1e3 * bounds_.force_slew_N_per_ms * kRounding - bounds_.force_N * factors - rates.led_force;
  rates.contact_torque = 1e3 * bounds_.torque_slew_Nm_per_ms * kRounding -
                         bounds_.torque_Nm * factors - rates.led_torque;
  return rates;
}

WrenchLimits WrenchLimits::Of(const DeviceInfo& info) {
  DeviceInfo device = info;
  // Without a motor there is nothing to bound, and a bound must be positive.
  if (device.torque_axes == 0) device.max_torque_Nm = device.continuous_torque_Nm = kNoTorque_Nm;
  CheckPositive(device.max_force_N, "max_force_N");
  CheckPositive(device.max_torque_Nm, "max_torque_Nm");
  CheckPositive(device.thermal_time_s, "thermal_time_s");
  CheckPositive(device.motion_scale, "motion_scale");
  if (device.thermal_time_s < TemperatureStage::kShortest_s) {
    throw Error("wrench limits: thermal_time_s is " + std::to_string(device.thermal_time_s) +
                "; no motor warms within a second (is it in seconds?)");
  }
  WrenchLimits limits;
  limits.bounds_.force_N = device.max_force_N;
  limits.bounds_.torque_Nm = device.max_torque_Nm;
  limits.bounds_.continuous_force_N = device.continuous_force_N;
  limits.bounds_.continuous_torque_Nm = device.continuous_torque_Nm;
  limits.bounds_.force_slew_N_per_ms = device.max_force_N / kWholePeak_ms;
  limits.bounds_.torque_slew_Nm_per_ms = device.max_torque_Nm / kWholePeak_ms;
  limits.bounds_.led_force_N = std::min(kLedForce_N, device.max_force_N);
  limits.bounds_.led_torque_Nm = std::min(kLedTorque_Nm, device.max_torque_Nm);
  limits.thermal_time_s_ = device.thermal_time_s;
  limits.motion_scale_ = device.motion_scale;
  limits.position_resolution_m_ = std::max(0.0, device.position_resolution_m);
  limits.rotation_resolution_rad_ = std::max(0.0, device.rotation_resolution_rad);
  return limits.TightenedTo(limits.bounds_);
}

WrenchLimits WrenchLimits::TightenedTo(const Bounds& bounds) const {
  const auto check = [](double value, double loosest, const char* name) {
    CheckPositive(value, name);
    if (value > loosest) {
      throw Error(std::string("wrench limits: ") + name + " is " + std::to_string(value) +
                  ", more than the " + std::to_string(loosest) +
                  " that the device allows; limits can only be tightened");
    }
  };
  check(bounds.force_N, bounds_.force_N, "force_N");
  check(bounds.torque_Nm, bounds_.torque_Nm, "torque_Nm");
  check(bounds.continuous_force_N, std::min(bounds_.continuous_force_N, bounds.force_N),
        "continuous_force_N");
  check(bounds.continuous_torque_Nm, std::min(bounds_.continuous_torque_Nm, bounds.torque_Nm),
        "continuous_torque_Nm");
  check(bounds.force_slew_N_per_ms, bounds_.force_slew_N_per_ms, "force_slew_N_per_ms");
  check(bounds.torque_slew_Nm_per_ms, bounds_.torque_slew_Nm_per_ms, "torque_slew_Nm_per_ms");
  check(bounds.led_force_N, std::min(bounds_.led_force_N, bounds.force_N), "led_force_N");
  check(bounds.led_torque_Nm, std::min(bounds_.led_torque_Nm, bounds.torque_Nm), "led_torque_Nm");
  WrenchLimits tighter = *this;
  tighter.bounds_ = bounds;
  const Rates rates = tighter.rates();
  if (!(rates.contact_force > 0.0) || !(rates.contact_torque > 0.0)) {
    throw Error(
        "wrench limits: the slew limit leaves no room for the fade; raise force_slew_N_per_ms and "
        "torque_slew_Nm_per_ms, or lower the peak");
  }
  return tighter;
}

}  // namespace palpate
