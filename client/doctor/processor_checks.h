#pragma once

#include <set>
#include <string>

#include "client/doctor/finding.h"
#include "client/doctor/host_files.h"

namespace palpate::doctor {

/// Cores as the kernel lists them: "2-3,6".  What is no number ("(null)", where there is none) is
/// left out.
std::set<int> ParseCores(const std::string& list);
std::string ToText(const std::set<int>& cores);

/// Whether cores run at their full frequency at once.
Finding CheckGovernor(const HostFiles& host);
/// Whether cores fall so fast asleep that a pose has to wait until they are awake.
Finding CheckIdleStates(const HostFiles& host);
/// Whether a core is kept for the loops.
Finding CheckIsolatedCores(const HostFiles& host);
/// Whether a loop shares its core's units with another thread.
Finding CheckHyperThreading(const HostFiles& host);

}  // namespace palpate::doctor
