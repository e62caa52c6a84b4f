#pragma once

#include "server/physics/solve/step_context.h"

namespace palpate {

/// Returns the step nearest to a target under the context's rigid rows and, if asked for, the
/// energies that act beside the coupling's.  The solver's first guess is the state's active pairs.
/// With 3 degrees of freedom the rotation is the hand's: no contact can turn a sphere about its
/// centre.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
Optimum NearestStep(const StepContext& context, const Target& target,
                    bool with_energies = false) noexcept;

/// Corrects the optimum of a ball under straight rows for rows that turn about an edge or corner of
/// a mesh.  Returns false, without a change, if no row turns.
///
/// Rows are straight within a sub-step and made anew in each.  Under such rows, a ball of radius r
/// that is pressed d deep past an edge approaches its place only by the factor d / r in each
/// sub-step: a millisecond later the force is still wrong by newtons.  With the rows' second order,
///   g_i(x) = g_i + n_i . x + 1/2 x . K_i x >= 0,   K_i = CurvatureOf,
/// the multipliers l_i of the optimum give x - t = sum l_i (n_i + K_i x): x is nearest to the
/// target t + sum l_i K_i x.  This is a step of sequential quadratic programming (Nocedal & Wright,
/// Numerical Optimization, 2nd ed. (2006), 18.1); for a single edge its direction is exact.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
bool RoundCreases(const StepContext& context, Optimum& optimum) noexcept;

/// Stores the rows that hold the tool at an optimum: the solver's next first guess.
void Remember(const StepContext& context, const Optimum& optimum) noexcept;

}  // namespace palpate
