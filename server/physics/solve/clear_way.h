#pragma once

#include <optional>

#include "server/physics/solve/step_context.h"

namespace palpate {

/// Computes the motion of a sub-step towards an optimum, as far as the bounds and the meshes allow
/// it.  Returns none if rows changed: the optimum must then be solved again.
///
/// If only leaves touch, the rows cover everything within the bounds.  Between meshes rows are
/// added on violation, so a motion is made only after it was checked: the meshes are apart at its
/// end and were apart on the way.  If rows follow the trials without success, they begin again in a
/// trust region a quarter as wide.  If a motion is still not free in the end, it is halved until it
/// is; the zero motion always is.  The tool counts as arrived only if the pairs that hold it touch.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
std::optional<Way> ClearWay(StepContext& context, const Optimum& optimum) noexcept;

}  // namespace palpate
