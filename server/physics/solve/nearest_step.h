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

/// Keeps which rows hold the tool at an optimum: the solver's first guess next time.
void Remember(const StepContext& context, const Optimum& optimum) noexcept;

}  // namespace palpate
