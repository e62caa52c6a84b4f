#pragma once

#include "tests/faults/findings.h"

namespace palpate::faults {

/// The recorder is killed again and again, at other moments of its work: what it had written is
/// whole, and how much that lacks of what was on the wire.
Findings RecorderKilled(int domain);

}  // namespace palpate::faults
