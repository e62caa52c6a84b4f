#include "server/physics/step_state.h"

namespace palpate {

StepState::StepState(const HapticModel& model) {
  if (model.parameters().features.removal) wear = LeafWear(model.objects());
  if (model.bodies() != nullptr) front.Reserve();
}

}  // namespace palpate
