#pragma once

#include <string_view>
#include <vector>

#include "common/step_tuning.h"
#include "scenes/scene.h"

namespace palpate {

/// What a paper varies of a scene, by its name in scene files, Python and C.
/// @field usual  of a scene that does not say.
/// @field value  of this one; not a number where its materials differ.
struct Parameter : Tunable {
  double usual = 0.0, value = 0.0;
};

/// All that there are: the springs, the step's StepTuning, and the friction of all that is touched.
std::vector<Parameter> ParametersOf(const Scene& scene);

/// Sets one, in its unit.  Models that have been made stay as they are.
/// Throws Error that names it, or those that there are, and the range; then nothing is changed.
void SetParameter(Scene& scene, std::string_view name, double value);

}  // namespace palpate
