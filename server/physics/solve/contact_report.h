#pragma once

#include "server/physics/solve/step_context.h"

namespace palpate {

/// Writes the contacts at a way's optimum into the context's report, relative to where the
/// way has taken the tool: each contact's force, the gap that its row has left there, and
/// where it touches. Real-time.
void ReportContacts(const StepContext& context, const Way& way) noexcept;

}  // namespace palpate
