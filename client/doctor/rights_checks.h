#pragma once

#include <optional>

#include "client/doctor/finding.h"
#include "client/doctor/host_files.h"
#include "common/program/realtime.h"

namespace palpate::doctor {

/// What the kernel gave this user when asked, as a program's loop asks.
struct Rights {
  bool fifo = false;
  bool memory_locked = false;
  std::optional<long long> rtprio{};      ///< ulimit -r; nothing: unlimited
  std::optional<long long> memlock_kB{};  ///< ulimit -l; nothing: unlimited
};

/// Tries, in a thread of its own: SCHED_FIFO ends with it, locked memory stays.
Rights TryRights(const RealtimeOptions& realtime);

/// May a loop preempt everything ordinary?  Where not, which of the four that can refuse it does.
Finding CheckScheduling(const HostFiles& host, const Rights& rights, int priority);
Finding CheckLockedMemory(const Rights& rights);
/// The kernel's net under a real-time thread that spins.
Finding CheckThrottling(const HostFiles& host);

}  // namespace palpate::doctor
