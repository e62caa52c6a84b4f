#pragma once

#include <string_view>
#include <vector>

#include "common/step_tuning.h"
#include "scenes/scene.h"

namespace palpate {

/// A parameter of a scene that a study may vary, by its name in scene files, Python and C.
/// @field usual  value in a scene that does not set it
/// @field value  value in this scene; not a number if its materials differ
struct Parameter : Tunable {
  double usual = 0.0, value = 0.0;
};

/// Returns all parameters: the springs, the step's StepTuning, and the friction of
/// everything that is touched.
std::vector<Parameter> ParametersOf(const Scene& scene);

/// Sets a parameter, in its unit.  Existing models do not change.
/// Throws Error, and sets nothing, if the value is out of range (the message names the range) or
/// the name is unknown (the message names all parameters).
void SetParameter(Scene& scene, std::string_view name, double value);

}  // namespace palpate
