#include "devices/limiter/wrench_limits.h"

#include <algorithm>
#include <sstream>
#include <string>

#include "common/error.h"
#include "devices/limiter/stages.h"

namespace palpate {
namespace {

/// Changes the whole peak in 5 ms.
constexpr double kWholePeak_ms = 5.0;
/// The most that a guide may request (client/station/guide.h), on any device.
constexpr double kLedForce_N = 1.0;
constexpr double kLedTorque_Nm = 0.01;
constexpr double kNoTorque_Nm = 1e-9;
/// Time in which a guide's whole force comes or goes.
constexpr double kLedWhole_s = 0.02;
/// Allowance for rounding in the sums of the proof, some 1e-15 of the peak, relative to a step of
/// 1 us.
constexpr double kRounding = 1.0 - 1e-6;
// |d(a e y)| <= |dy| + |y| (|da| + |de|), and y itself changes with contact, guide and temperature.
constexpr double kFactors_1_s =
    AgeStage::kFastest_1_s + EnableStage::kFastest_1_s + TemperatureStage::kFastest_1_s;
static_assert(1e3 / kWholePeak_ms * kRounding > kFactors_1_s + 1.0 / kLedWhole_s,
              "the slew limit leaves the contact room beside the fade and a guide at its most");

/// No arm's figure is outside of its range; beyond it, the stages' numbers would over- or
/// underflow.
struct Range {
  const char* name;
  double DeviceInfo::*figure;
  double least, most;
};
constexpr Range kRanges[] = {
    {"max_force_N", &DeviceInfo::max_force_N, 1e-3, 1e4},
    {"max_torque_Nm", &DeviceInfo::max_torque_Nm, kNoTorque_Nm, 1e4},
    {"continuous_force_N", &DeviceInfo::continuous_force_N, 1e-3, 1e4},
    {"continuous_torque_Nm", &DeviceInfo::continuous_torque_Nm, kNoTorque_Nm, 1e4},
    {"thermal_time_s", &DeviceInfo::thermal_time_s, TemperatureStage::kShortest_s, 3600.0},
    {"motion_scale", &DeviceInfo::motion_scale, 1e-3, 1e3},
    {"position_resolution_m", &DeviceInfo::position_resolution_m, 0.0, 1.0},
    {"rotation_resolution_rad", &DeviceInfo::rotation_resolution_rad, 0.0, 1.0}};
constexpr double kLeastForce_N = 1e-3;

std::string Shown(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

void Check(const DeviceInfo& device) {
  for (const auto& [name, figure, least, most] : kRanges) {
    const double value = device.*figure;
    if (value >= least && value <= most) continue;
    throw Error(std::string("wrench limits: ") + name + " is " + Shown(value) +
                "; it must be from " + Shown(least) + " to " + Shown(most) +
                " in SI units (does the device's info() give it?)");
  }
}

}  // namespace

WrenchLimits::Rates WrenchLimits::rates() const noexcept {
  Rates rates;
  rates.led_force = bounds_.led_force_N / kLedWhole_s;
  rates.led_torque = bounds_.led_torque_Nm / kLedWhole_s;
  rates.contact_force = 1e3 * bounds_.force_slew_N_per_ms * kRounding -
                        bounds_.force_N * kFactors_1_s - rates.led_force;
  rates.contact_torque = 1e3 * bounds_.torque_slew_Nm_per_ms * kRounding -
                         bounds_.torque_Nm * kFactors_1_s - rates.led_torque;
  return rates;
}

WrenchLimits WrenchLimits::Of(const DeviceInfo& info, double most_force_N) {
  DeviceInfo device = info;
  // Without a motor any bound will do, but it must be positive.
  if (device.torque_axes == 0) device.max_torque_Nm = device.continuous_torque_Nm = kNoTorque_Nm;
  Check(device);
  if (device.continuous_force_N > device.max_force_N ||
      device.continuous_torque_Nm > device.max_torque_Nm) {
    throw Error("wrench limits: the device's continuous force or torque is above its peak");
  }
  if (!(most_force_N >= kLeastForce_N)) {
    throw Error("wrench limits: a maximum force of " + Shown(most_force_N) + " N; give at least " +
                Shown(kLeastForce_N));
  }
  const double share = std::min(1.0, most_force_N / device.max_force_N);
  WrenchLimits limits;
  limits.bounds_.force_N = share * device.max_force_N;
  limits.bounds_.torque_Nm = share * device.max_torque_Nm;
  limits.bounds_.continuous_force_N = std::min(device.continuous_force_N, limits.force_N());
  limits.bounds_.continuous_torque_Nm = std::min(device.continuous_torque_Nm, limits.torque_Nm());
  // The device's own: what goes slowly the energy stage has to foresee for long, and a weak force
  // never has so much in store.
  limits.bounds_.force_slew_N_per_ms = device.max_force_N / kWholePeak_ms;
  limits.bounds_.torque_slew_Nm_per_ms = device.max_torque_Nm / kWholePeak_ms;
  limits.bounds_.led_force_N = std::min(kLedForce_N, limits.force_N());
  limits.bounds_.led_torque_Nm = std::min(kLedTorque_Nm, limits.torque_Nm());
  limits.thermal_time_s_ = device.thermal_time_s;
  limits.motion_scale_ = device.motion_scale;
  limits.position_resolution_m_ = device.position_resolution_m;
  limits.rotation_resolution_rad_ = device.rotation_resolution_rad;
  return limits;
}

}  // namespace palpate
