#pragma once

#include "tests/faults/findings.h"

namespace palpate::faults {

// A /dev/shm of the test's own, in a mount namespace of its own, with an own RouDi.  Where the
// machine gives no such namespace, the findings say so.

/// It is full before RouDi and the programs start.
Findings SharedMemoryTooSmall(int domain);
/// It is filled under programs that run, and others start then.
Findings SharedMemoryFills(int domain);

}  // namespace palpate::faults
