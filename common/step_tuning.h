#pragma once

#include <string>

namespace palpate {

/// The parameters of the haptic step, beside its spring, that a researcher may vary.  The
/// defaults are given here, the units and ranges by ForEachField, and what each derives from
/// in server/physics/limits.h.
struct StepTuning {
  double separation = 1e-6;     ///< delta, the distance that contact keeps between meshes [m]
  double widest_step = 0.5e-3;  ///< upper limit of the bound on |v| of one sub-step [m]
  int sub_steps = 12;           ///< at most, in a cycle
  int iterates = 16;            ///< at most, rounds of solve and check in a sub-step (meshes)
  int queries = 3400;           ///< a cycle's budget for contact between meshes; about 130 ns each
  int still_cycles = 20;        ///< cycles without slip after which friction is static again

  bool operator==(const StepTuning&) const = default;
};

/// Describes a parameter to the user who varies it.
struct Tunable {
  const char* name;    ///< in scene files, Python and C
  const char* unit;    ///< of the user's number; empty: a count or a ratio
  double scale;        ///< the step's value is the user's number times this
  double least, most;  ///< bounds of the user's number
  const char* what;    ///< for people
};

/// The bounds of what a scene has beside its StepTuning, for all doors: scene files, bundles, the
/// library in C++ and C, and Python.
inline constexpr Tunable kCouplingStiffness{
    "stiffness_N_per_m", "N/m", 1.0, 0.01, 1e5, "stiffness k_t of the virtual coupling"};
inline constexpr Tunable kCouplingTorsionalStiffness{
    "torsional_stiffness_Nm_per_rad",
    "N m/rad",
    1.0,
    1e-4,
    1e4,
    "torsional stiffness k_r of the virtual coupling"};
inline constexpr Tunable kFriction{
    // rubber on rubber is below 4
    "friction", "", 1.0, 0.0, 10.0, "static and dynamic friction of all objects"};

/// Returns which spring of the virtual coupling is out of its range, in words; empty if none is.
std::string SpringFault(double stiffness, double torsional_stiffness);
/// Returns what is wrong with a material, in words; empty if nothing is.
/// @param stiffness  of a leaf's contact [N/m], above 0; infinite: rigid
/// @param static_friction,dynamic_friction  coefficients of friction
std::string MaterialFault(double stiffness, double static_friction, double dynamic_friction);

/// Calls visit(tunable, field) for each field.
template <class Tuning, class Visit>
void ForEachField(Tuning& tuning, Visit visit) {
  visit(Tunable{"separation_um", "um", 1e-6, 0.01, 100.0, "gap kept between meshes in contact"},
        tuning.separation);
  visit(Tunable{"widest_step_mm", "mm", 1e-3, 0.001, 10.0,
                "largest motion of the tool in a sub-step"},
        tuning.widest_step);
  visit(Tunable{"sub_steps", "", 1.0, 1.0, 64.0, "largest number of sub-steps in a cycle"},
        tuning.sub_steps);
  visit(Tunable{"iterates", "", 1.0, 1.0, 256.0,
                "largest number of solve-and-check rounds in a sub-step"},
        tuning.iterates);
  visit(Tunable{"queries", "", 1.0, 100.0, 50'000.0,
                "budget of contact queries in a cycle, 130 ns each"},
        tuning.queries);
  visit(Tunable{"still_cycles", "", 1.0, 0.0, 10'000.0,
                "cycles without slip until friction is static"},
        tuning.still_cycles);
}

/// Returns what is wrong with a number, in words; empty if it is allowed.
/// `whole`: it must be an integer.
std::string RangeFault(const Tunable& tunable, double value, bool whole);

/// Returns which field is out of its range, in words; empty if none is.
std::string TuningFault(const StepTuning& tuning);

}  // namespace palpate
