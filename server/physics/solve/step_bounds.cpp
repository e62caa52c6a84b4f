#include "server/physics/solve/step_bounds.h"

#include <algorithm>

#include "server/physics/limits.h"

namespace palpate {
namespace {

/// Widest bounds of a sub-step.  Rows between surfaces cost more than those between spheres: near a
/// surface a sub-step takes any point of the tool no further than kNearSurface by translation, and
/// as far by rotation; eight of them still follow a hand at 0.8 m/s.
StepBounds WidestBounds(const HapticModel& model, bool near) {
  constexpr double kNearSurface = 0.1e-3;
  const StepParameters& parameters = model.parameters();
  if (!near || model.tool_surface() == nullptr) {
    return {parameters.max_translation, parameters.max_rotation};
  }
  const double lever = std::max(model.tool().max_lever(), limits::kShortestLever);
  return {std::min(parameters.max_translation, kNearSurface),
          std::min(parameters.max_rotation, kNearSurface / lever)};
}

}  // namespace

StepBounds FirstBounds(const HapticModel& model, const Target& hand_step, bool near) noexcept {
  const StepBounds widest = WidestBounds(model, near);
  const StepParameters& parameters = model.parameters();
  const bool surface = model.tool_surface() != nullptr;
  const double of_hand = surface ? 1.4 : limits::kBoundsOverHand;
  const double of_most = surface ? 0.02 : limits::kLeastBounds;
  const double rho = model.rotation_length();
  const double v = hand_step.v.norm(), phi = hand_step.phi.norm();
  return {std::min(of_hand * (v + limits::kBoundsAcross * rho * phi) +
                       of_most * parameters.max_translation,
                   widest.translation),
          std::min(
              of_hand * (phi + limits::kBoundsAcross * v / rho) + of_most * parameters.max_rotation,
              widest.rotation)};
}

StepBounds WiderBounds(const HapticModel& model, const StepBounds& bounds, const Vec3& v,
                       const Vec3& phi, bool near) noexcept {
  const StepBounds widest = WidestBounds(model, near);
  double translation = limits::kWiden * bounds.translation;
  double rotation = limits::kWiden * bounds.rotation;
  if (model.tool_surface() != nullptr) {
    translation = std::min(translation, std::max(1.25 * v.norm(), 2.0 * bounds.translation));
    rotation = std::min(rotation, std::max(1.25 * phi.norm(), 2.0 * bounds.rotation));
  }
  return {std::min(translation, widest.translation), std::min(rotation, widest.rotation)};
}

double PartWithin(const StepBounds& bounds, int degrees_of_freedom, const Vec3& v,
                  const Vec3& phi) noexcept {
  const double length = v.norm(), angle = phi.norm();
  double part = 1.0;
  if (length > bounds.translation) part = bounds.translation / length;
  if (degrees_of_freedom == 6 && angle * part > bounds.rotation) part = bounds.rotation / angle;
  return part;
}

}  // namespace palpate
