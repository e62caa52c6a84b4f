#pragma once

#include "tests/faults/findings.h"

namespace palpate::faults {

/// The wall clock of server, station, gateway and recorder, one after the other, goes an hour ahead
/// and back, and an hour back and ahead (tests/faults/clock_shim.cpp).
Findings ClockSteps(int domain);

}  // namespace palpate::faults
