#include "server/physics/step_state.h"

#include <string>

namespace palpate {

StepState::StepState(const HapticModel& model) : effects(model.effects().Begin()) {
  if (model.tool_body() != nullptr) {
    front.Reserve();
    if (!model.boxes().empty()) felt = FeltSolids(model.uncut());
  }
  cutting = model.cutting() == nullptr || !model.cutting()->sense;
  for (const CutSolid& solid : model.solids()) {
    cuts.emplace_back(*solid.grid, kMostGridBytes, "solid " + std::to_string(cuts.size()));
  }
}

}  // namespace palpate
