#include "devices/limiter/limiter_chain.h"

namespace palpate {

std::string TemperatureRemark(const LimiterCounts& counts) {
  if (counts.too_hot > 0) {
    return "the driver reports a motor temperature above 1; it counts as 1, so only the continuous "
           "force is left: report 0 (cool) to 1 (the motor's limit)";
  }
  if (counts.too_cold > 0) {
    return "the driver reports a negative motor temperature; it counts as unknown, so a model of "
           "the motors limits the force: report 0 (cool) to 1 (the motor's limit), or NaN";
  }
  if (counts.calls > 0 && counts.no_temperature == counts.calls) {
    return "the driver reports no motor temperature: a model of the motors limits the force";
  }
  return "";
}

}  // namespace palpate
