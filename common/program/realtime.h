#pragma once

#include <string>

namespace palpate {

enum class RealtimeMode {
  kRequire,  ///< fail if a right is missing
  kPrefer,   ///< use what is granted and report what is not
  kOff,
};

/// Parses "require", "prefer", "off"; throws UsageError.
RealtimeMode ParseRealtimeMode(const std::string& text);

/// @field cpu       core to pin to; -1: any.
/// @field priority  SCHED_FIFO, 1 to 99; below the kernel's interrupt threads, which run at 50.
struct RealtimeOptions {
  RealtimeMode mode = RealtimeMode::kPrefer;
  int cpu = -1;
  int priority = 40;
};

/// What was obtained.
/// @field summary  one line, for the log: "SCHED_FIFO 40, memory locked, core 1", or what is
///                 missing and the remedy.
struct RealtimeReport {
  bool fifo = false;
  bool memory_locked = false;
  bool pinned = false;
  std::string summary;
};

/// Makes the calling thread, and every thread that it creates from now on, real-time: SCHED_FIFO,
/// pinned to options.cpu.  Locks the process's present and future memory: pages stay resident once
/// touched (so that the untouched part of a stack costs nothing), and 256 kB of this stack are
/// touched.  Does not lock if a limit (ulimit -l) would then refuse further memory.  With kRequire
/// it throws Error (limit, remedy) if any part is refused; kOff only pins.  A core that does not
/// exist is a UsageError in any mode.
RealtimeReport EnterRealtime(const RealtimeOptions& options);

/// Returns the calling thread to ordinary scheduling on its former cores, which the threads that it
/// creates next inherit.  Memory stays locked.
void LeaveRealtime();

}  // namespace palpate
