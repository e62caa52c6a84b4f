#include <algorithm>

#include "server/physics/limits.h"
#include "server/physics/solve/stages.h"

namespace palpate {
namespace {

StepBounds Narrowed(const StepBounds& bounds, const StepParameters& parameters) {
  return {std::min(bounds.translation, parameters.widest_step),
          std::min(bounds.rotation, parameters.max_rotation)};
}

}  // namespace

StepBounds FirstBounds(const HapticModel& model, const Target& hand_step) noexcept {
  const StepParameters& parameters = model.parameters();
  const double rho = model.rotation_length();
  const double v = hand_step.v.norm(), phi = hand_step.phi.norm();
  const double across = model.tool_body() == nullptr ? limits::kBoundsAcross : 0.0;
  constexpr double over = limits::kBoundsOverHand;
  return Narrowed(
      {over * (v + across * rho * phi) + limits::kLeastBounds * parameters.widest_step,
       over * (phi + across * v / rho) + limits::kLeastBounds * parameters.max_rotation},
      parameters);
}

StepBounds NextBounds(const StepParameters& parameters, const StepBounds& bounds, double part,
                      double paid) noexcept {
  double by = part == 1.0 ? std::min(paid, limits::kWiden) : part;
  // A way no longer than the separation has as many near pairs as none.
  const double least = std::min(parameters.separation / bounds.translation, 1.0);
  by = std::max({by, limits::mesh::kNarrow, least});
  return Narrowed({by * bounds.translation, by * bounds.rotation}, parameters);
}

double PartWithin(const StepBounds& bounds, const Vec3& v, const Vec3& phi) noexcept {
  const double length = v.norm(), angle = phi.norm();
  double part = 1.0;
  if (length > bounds.translation) part = bounds.translation / length;
  if (angle * part > bounds.rotation) part = bounds.rotation / angle;
  return part;
}

}  // namespace palpate
