#pragma once

#include "server/physics/solve/step_context.h"

namespace palpate {

/// The step nearest to a target under the context's rigid rows and, where asked for, the energies
/// that act beside the coupling's.  The solver's first guess are the state's active pairs.
/// With 3 degrees of freedom the rotation is the hand's: no contact can turn a sphere about its
/// centre.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
Optimum NearestStep(const StepContext& context, const Target& target,
                    bool with_energies = false) noexcept;

/// Takes an optimum, that of a ball under straight rows, on to where its rows lead that
/// turn about an edge or a corner of a mesh.  False where none turns: the optimum stays.
///
/// Under rows that are made anew in each sub-step and are straight in it, a ball that is pressed d
/// deep past an edge comes nearer to its place by d / r only in each, r its radius: a millisecond
/// later the force is still off by newtons.  With the rows' second order,
///   g_i(x) = g_i + n_i . x + 1/2 x . K_i x >= 0,   K_i = CurvatureOf,
/// the multipliers l_i of the optimum give x - t = sum l_i (n_i + K_i x): x is nearest to the
/// target t + sum l_i K_i x.  That is the step of sequential quadratic programming (Nocedal &
/// Wright, Numerical Optimization, 2nd ed. (2006), 18.1); of one edge its direction is exact.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
bool RoundCreases(const StepContext& context, Optimum& optimum) noexcept;

/// Keeps which rows hold the tool at an optimum: the solver's first guess next time.
void Remember(const StepContext& context, const Optimum& optimum) noexcept;

}  // namespace palpate
