#pragma once

#include "client/doctor/finding.h"
#include "client/doctor/host_files.h"

namespace palpate::doctor {

/// Whether cores run at their full frequency at once.
Finding CheckGovernor(const HostFiles& host);
/// Whether cores fall so fast asleep that a pose has to wait until they are awake.
Finding CheckIdleStates(const HostFiles& host);
/// Whether a core is kept for the loops.
Finding CheckIsolatedCores(const HostFiles& host);
/// Whether a loop shares its core's units with another thread.
Finding CheckHyperThreading(const HostFiles& host);

}  // namespace palpate::doctor
