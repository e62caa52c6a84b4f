#pragma once

#include <optional>

#include "server/physics/solve/step_context.h"

namespace palpate {

/// The motion of a sub-step towards an optimum, as far as the bounds and the meshes let it.  None
/// where the rows had to change: then the optimum is to be solved for again.
///
/// Where leaves alone meet, the rows cover all that the bounds allow.  Between meshes they come on
/// violation, so a motion is only made that has been checked: the meshes are apart at its end and
/// were on the way.  Rows that follow the trials in vain begin anew, in a trust region a quarter as
/// wide.  A motion that is still not free in the end is halved until it is; no motion at all always
/// is.  The tool has arrived only where the pairs that hold it touch.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
std::optional<Way> ClearWay(StepContext& context, const Optimum& optimum) noexcept;

}  // namespace palpate
