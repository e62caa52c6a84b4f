#include "common/step_tuning.h"

#include <cmath>
#include <sstream>

namespace palpate {

std::string RangeFault(const Tunable& tunable, double value, bool whole) {
  const auto& [name, unit, scale, least, most, what] = tunable;
  if (value >= least && value <= most && (!whole || value == std::floor(value))) return "";
  std::ostringstream fault;
  fault << name << " is " << value << "; give " << (whole ? "a whole number" : "a number")
        << " from " << least << " to " << most;
  return fault.str();
}

std::string SpringFault(double stiffness, double torsional_stiffness) {
  const std::string fault = RangeFault(kCouplingStiffness, stiffness, false);
  return !fault.empty() ? fault
                        : RangeFault(kCouplingTorsionalStiffness, torsional_stiffness, false);
}

std::string MaterialFault(double stiffness, double static_friction, double dynamic_friction) {
  if (!(stiffness > 0.0)) return "stiffness must be above 0; infinite: rigid";
  if (static_friction >= dynamic_friction && dynamic_friction >= kFriction.least &&
      static_friction <= kFriction.most) {
    return "";
  }
  std::ostringstream fault;
  fault << "friction: is " << static_friction << " static, " << dynamic_friction
        << " dynamic; must be " << kFriction.least << " <= dynamic <= static <= " << kFriction.most;
  return fault.str();
}

std::string TuningFault(const StepTuning& tuning) {
  std::string fault;
  ForEachField(tuning, [&](const Tunable& tunable, const auto& number) {
    // Rounds to a billionth, so that rounding by the scale does not reject a bound that a user
    // has set.
    const double value = std::round(number / tunable.scale * 1e9) / 1e9;
    if (fault.empty()) fault = RangeFault(tunable, value, false);
  });
  return fault;
}

}  // namespace palpate
