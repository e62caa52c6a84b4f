#include "common/step_tuning.h"

#include <cmath>
#include <sstream>
#include <type_traits>

#include "common/error.h"

namespace palpate {
namespace {

std::string RangeFault(std::string_view name, double value, double least, double most, bool whole) {
  if (value >= least && value <= most && (!whole || value == std::floor(value))) return "";
  std::ostringstream fault;
  fault << name << " is " << value << "; give " << (whole ? "a whole number" : "a number")
        << " from " << least << " to " << most;
  return fault.str();
}

}  // namespace

void SetField(StepTuning& tuning, std::string_view name, double value) {
  bool found = false;
  std::string names;
  ForEachField(
      tuning, [&](const char* field, auto& number, double scale, double least, double most) {
        using Number = std::remove_reference_t<decltype(number)>;
        names += (names.empty() ? "" : ", ") + std::string(field);
        if (name != field) return;
        found = true;
        const std::string fault = RangeFault(name, value, least, most, std::is_integral_v<Number>);
        if (!fault.empty()) throw Error("step: " + fault);
        number = static_cast<Number>(scale * value);
      });
  if (!found) throw Error("step: " + std::string(name) + " is no field; there are " + names);
}

std::string TuningFault(const StepTuning& tuning) {
  std::string fault;
  ForEachField(tuning,
               [&](const char* field, const auto& number, double scale, double least, double most) {
                 // To a billionth: what SetField has taken passes, whatever its scale's rounding.
                 const double value = std::round(number / scale * 1e9) / 1e9;
                 if (fault.empty()) fault = RangeFault(field, value, least, most, false);
               });
  return fault;
}

}  // namespace palpate
