#pragma once

#include <string>

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

/// What a number that may be varied is to those who vary it.
struct Tunable {
  const char* name;    ///< in scene files, Python and C
  const char* unit;    ///< of the number there; empty: a count or a ratio
  double scale;        ///< what the step has is this times the number there
  double least, most;  ///< of the number there
  const char* what;    ///< for people
};

/// Calls visit(tunable, field) for each field.
template <class Tuning, class Visit>
void ForEachField(Tuning& tuning, Visit visit) {
  visit(Tunable{"separation_um", "um", 1e-6, 0.01, 100.0, "what contact keeps between meshes"},
        tuning.separation);
  visit(Tunable{"widest_step_mm", "mm", 1e-3, 0.001, 10.0, "what a sub-step may move the tool by"},
        tuning.widest_step);
  visit(Tunable{"sub_steps", "", 1.0, 1.0, 64.0, "of a cycle at most"}, tuning.sub_steps);
  visit(Tunable{"iterates", "", 1.0, 1.0, 256.0, "rounds of solve and check in a sub-step"},
        tuning.iterates);
  visit(Tunable{"looks", "", 1.0, 100.0, 50'000.0, "what a cycle's contact may cost, 130 ns each"},
        tuning.looks);
  visit(Tunable{"still_cycles", "", 1.0, 0.0, 10'000.0, "without slip, until friction is static"},
        tuning.still_cycles);
}

/// What is wrong with a number, in words; empty where it may be.
/// `whole`: it is a count.
std::string RangeFault(const Tunable& tunable, double value, bool whole);

/// Which field is out of its range, in words; empty where none is.
std::string TuningFault(const StepTuning& tuning);

}  // namespace palpate
