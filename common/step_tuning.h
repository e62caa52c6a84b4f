#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// What a researcher may vary of the haptic step, beside its spring.  What is left out has these
/// values; ForEachField has units and ranges, and server/physics/limits.h what each derives from.
struct StepTuning {
  double separation = 1e-6;     ///< delta that contact keeps between meshes [m]
  double widest_step = 0.5e-3;  ///< greatest bound on |v| of one sub-step [m]
  int sub_steps = 8;            ///< of a cycle at most
  int iterates = 16;            ///< rounds of solve and check in a sub-step at most, between meshes
  int looks = 3400;       ///< what a cycle's contact between meshes may cost; some 130 ns each
  int still_cycles = 20;  ///< without slip, after which friction is static again

  bool operator==(const StepTuning&) const = default;
};

/// Calls visit(name, field, scale, least, most) for each field: by its name in scene files, Python
/// and C, which has its unit; value = scale * the number there, which lies within [least, most].
template <class Tuning, class Visit>
void ForEachField(Tuning& tuning, Visit visit) {
  visit("separation_um", tuning.separation, 1e-6, 0.01, 100.0);
  visit("widest_step_mm", tuning.widest_step, 1e-3, 0.001, 10.0);
  visit("sub_steps", tuning.sub_steps, 1.0, 1.0, 64.0);
  visit("iterates", tuning.iterates, 1.0, 1.0, 256.0);
  visit("looks", tuning.looks, 1.0, 100.0, 50'000.0);
  visit("still_cycles", tuning.still_cycles, 1.0, 0.0, 10'000.0);
}

/// Sets the field of such a name.  Throws Error that names it, or the fields that there are, and
/// the range; then nothing is changed.
void SetField(StepTuning& tuning, std::string_view name, double value);

/// Which field is out of its range, in words; empty where none is.
std::string TuningFault(const StepTuning& tuning);

}  // namespace palpate
