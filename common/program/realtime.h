#pragma once

#include <string>

namespace palpate {

enum class RealtimeMode {
  kRequire,  ///< fail where a right is missing
  kPrefer,   ///< take what is granted and say what is not
  kOff,
};

/// Parses "require", "prefer", "off"; throws UsageError.
RealtimeMode ParseRealtimeMode(const std::string& text);

/// @field cpu       core to stay on; -1: any.
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
/// pinned to options.cpu.  Locks the process's memory, that which it asks for later too: pages stay
/// once touched (so that a thread's untouched stack costs nothing), and 256 kB of this stack are
/// touched.  Not where a limit (ulimit -l) would then refuse it memory.  With kRequire throws
/// Error (limit, remedy) where a part is refused; kOff only pins; a core that does not exist is a
/// UsageError in any mode.
RealtimeReport EnterRealtime(const RealtimeOptions& options);

/// Puts the calling thread back to ordinary scheduling on its former cores, for the threads that it
/// creates next.  Memory stays locked.
void LeaveRealtime();

}  // namespace palpate
