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
