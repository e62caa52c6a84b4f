#pragma once

#include "server/physics/solve/step_context.h"

namespace palpate {

/// Writes the contacts at a way's optimum into the context's report, as seen from where it has
/// taken the tool: the force of each, what its row still allows from there, and where it touches.
/// Real-time.
void ReportContacts(const StepContext& context, const Way& way) noexcept;

}  // namespace palpate
