#pragma once

#include "server/physics/solve/step_context.h"

namespace palpate {

/// Writes the contacts of the sub-step into the context's report, as seen from where [v; phi] has
/// taken the tool: the force of each, what its row still allows from there, and where it touches.
/// Real-time.
void ReportContacts(StepContext& context) noexcept;

}  // namespace palpate
