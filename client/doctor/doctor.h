#pragma once

#include <functional>
#include <optional>
#include <string>

#include "client/doctor/options.h"
#include "client/doctor/report.h"
#include "common/program/stop_signal.h"

namespace palpate::doctor {

/// "lab-3: AMD Ryzen 7 5700G, 8 cores".
std::string HostLine();

/// All checks of this host, in the order in which a person would mend things; nothing where the
/// user stopped it.  To be called while this process has no other thread.
/// @param found      called with each finding as it comes.
/// @param measuring  called before what takes its time, with what it is.
std::optional<Report> Examine(const Options& options, StopSignal& stop,
                              const std::function<void(const Finding&)>& found,
                              const std::function<void(const std::string&)>& measuring);

}  // namespace palpate::doctor
