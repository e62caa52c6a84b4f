#include <algorithm>

#include "server/physics/limits.h"
#include "server/physics/solve/stages.h"

namespace palpate {

StepBounds Clamped(const StepParameters& parameters, const StepBounds& bounds) noexcept {
  const double least = parameters.separation / parameters.widest_step;
  const auto clamped = [least](double bound, double widest) {
    return std::min(std::max(bound, least * widest), widest);
  };
  return {clamped(bounds.translation, parameters.widest_step),
          clamped(bounds.rotation, parameters.max_rotation)};
}

StepBounds FirstBounds(const HapticModel& model, const Target& hand_step) noexcept {
  const StepParameters& parameters = model.parameters();
  const double rho = model.rotation_length();
  const double v = hand_step.v.norm(), phi = hand_step.phi.norm();
  const double across = model.tool_body() == nullptr ? limits::kBoundsAcross : 0.0;
  constexpr double over = limits::kBoundsOverHand;
  return Clamped(
      parameters,
      {over * (v + across * rho * phi) + limits::kLeastBounds * parameters.widest_step,
       over * (phi + across * v / rho) + limits::kLeastBounds * parameters.max_rotation});
}

StepBounds NextBounds(const StepParameters& parameters, const StepBounds& bounds, double fraction,
                      double paid) noexcept {
  const double by =
      std::max(fraction == 1.0 ? std::min(paid, limits::kWiden) : fraction, limits::mesh::kNarrow);
  return Clamped(parameters, {by * bounds.translation, by * bounds.rotation});
}

double FractionWithin(const StepBounds& bounds, const Vec3& v, const Vec3& phi) noexcept {
  const double length = v.norm(), angle = phi.norm();
  double fraction = 1.0;
  if (length > bounds.translation) fraction = bounds.translation / length;
  if (angle * fraction > bounds.rotation) fraction = bounds.rotation / angle;
  return fraction;
}

}  // namespace palpate
