#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/doctor/host_files.h"
#include "common/dds/network.h"
#include "common/dds/participant.h"
#include "common/program/realtime.h"
#include "common/program/stop_signal.h"
#include "common/realtime/histogram.h"
#include "devices/device_factory.h"

namespace palpate::doctor {

enum class Status {
  kOk,
  kWarning,  ///< holds 1 kHz, but less well than it could, or not for every user
  kFault,    ///< does not hold 1 kHz, or does not work at all
};

/// The result of one check.
struct Finding {
  std::string check{};  ///< name that a script looks for: "idle states"; set by Examine
  Status status = Status::kOk;
  std::string found{};
  std::string remedy{};  ///< what to do, with the command or file; empty if ok
};

inline Finding Ok(std::string found) {
  return {.found = std::move(found)};
}
inline Finding Warning(std::string found, std::string remedy) {
  return {.status = Status::kWarning, .found = std::move(found), .remedy = std::move(remedy)};
}
inline Finding Fault(std::string found, std::string remedy) {
  return {.status = Status::kFault, .found = std::move(found), .remedy = std::move(remedy)};
}

/// Returns the remedy's text for setting a kernel option.
inline std::string GrubLine(const std::string& option) {
  return "add " + option + " to GRUB_CMDLINE_LINUX in /etc/default/grub, run sudo update-grub";
}

/// The worst status of all.
inline Status Worst(const std::vector<Finding>& findings) {
  Status worst = Status::kOk;
  for (const Finding& finding : findings) worst = std::max(worst, finding.status);
  return worst;
}

/// Checks how soon the kernel schedules a real-time thread: with PREEMPT_RT, or else by its
/// preemption mode.
Finding CheckKernel(const HostFiles& host);
/// Checks whether the clock is read without a system call.
Finding CheckClockSource(const HostFiles& host);

/// The rights that the kernel granted this user when asked as a program's loop asks.
struct Rights {
  bool fifo = false;
  bool memory_locked = false;
  std::optional<long long> rtprio{};      ///< ulimit -r; nothing: unlimited
  std::optional<long long> memlock_kB{};  ///< ulimit -l; nothing: unlimited
};

/// Tries to get the rights in a thread of its own: SCHED_FIFO ends with that thread, locked
/// memory stays.
Rights TryRights(const RealtimeOptions& realtime);

/// Checks whether a loop may preempt all ordinary threads; if not, says which of the four possible
/// causes refuses it.
Finding CheckScheduling(const HostFiles& host, const Rights& rights, int priority);
Finding CheckLockedMemory(const Rights& rights);
/// Checks the kernel's throttling of real-time threads that spin.
Finding CheckThrottling(const HostFiles& host);

/// Parses a list of cores in the kernel's format: "2-3,6".  Skips what is not a number ("(null)"
/// for an empty list).
std::set<int> ParseCores(const std::string& list);
std::string ToText(const std::set<int>& cores);

/// Checks whether cores run at full frequency without a delay.
Finding CheckGovernor(const HostFiles& host);
/// Checks whether cores enter sleep states so deep that a pose has to wait for the wake-up.
Finding CheckIdleStates(const HostFiles& host);
/// Checks whether a core is reserved for the loops.
Finding CheckIsolatedCores(const HostFiles& host);
/// Checks whether a loop shares its core's execution units with another thread.
Finding CheckHyperThreading(const HostFiles& host);

/// Space that RouDi needs in /dev/shm with the project's pools; a test compares the two.
inline constexpr long long kSharedMemoryNeeded_MB = 117;

struct Space {
  long long size_MB = 0;
  long long free_MB = 0;
};
/// Returns the space of the file system that holds the folder; nothing if there is no such folder.
std::optional<Space> SpaceIn(const HostFiles& host, const std::string& folder);

/// The state of RouDi, the daemon that manages the shared memory, on this host.
struct RouDiState {
  bool socket = false;   ///< /tmp/roudi is there
  bool answers = false;  ///< a process holds the socket open
  /// The lock is held as by a living RouDi or, if that cannot be seen, the socket answers.
  bool lock_held = false;
  /// RouDi files that belong to another user; while they exist, only that user can start a RouDi.
  /// Each is preceded by a space.
  std::string closed{};
  long long owner = -1;                ///< user id of the socket's owner
  bool may_connect = false;            ///< this user may open the socket
  std::optional<std::string> pools{};  ///< file that it was started with; "" if none
};
RouDiState LookAtRouDi(const HostFiles& host);

/// @param wanted  with kUdp, shared memory is not needed.
Finding CheckSharedMemory(const std::optional<Space>& space, bool roudi_runs,
                          dds::Transport wanted);
/// @param pools  file to start RouDi with, for the remedy.
Finding CheckRouDi(const RouDiState& roudi, dds::Transport wanted, long long user,
                   const std::string& pools);

/// A network interface with an IPv4 address.
struct Interface {
  std::string name;
  bool up = false;
  bool multicast = false;
};
std::vector<Interface> InterfacesOfThisHost();

/// Checks whether programs can find each other over --network.
Finding CheckNetwork(const std::vector<Interface>& interfaces, const dds::Network& network);

/// Checks whether the UDP ports of --domain are free, or used by a palpate-server.
/// @param server_runs  a server runs in this domain on this host.
Finding CheckPorts(const HostFiles& host, int domain, bool server_runs);
/// Checks how much a socket may hold until it is read.
Finding CheckReceiveBuffer(const HostFiles& host);
/// Returns whether a palpate-server of this host uses this domain.
bool ServerRuns(const HostFiles& host, int domain);

/// The result of a trial in which two processes exchanged poses and wrenches as a station and a
/// server do.  Plain data: it is passed through a pipe.
struct LoopTrial {
  bool finished = false;  ///< the figures below are valid
  bool shared_memory = false;
  std::uint64_t sent = 0;
  std::uint64_t lost = 0;
  double p50_us = 0.0;  ///< round trip
  double p99_us = 0.0;
  double max_us = 0.0;
  char error[512] = {};  ///< why it did not finish; empty if it hung or died
};

struct LoopOptions {
  int domain = 0;
  dds::Transport transport = dds::Transport::kAuto;
  dds::Network network{};
  RealtimeOptions realtime{};
};

/// Runs the trial for about a second in two processes of its own, so that a hanging RouDi or an
/// aborting library ends only those.  Call it while this process has no other thread.
/// @param stop  ends the trial early; created before the processes, so that both see a signal.
LoopTrial TryLoop(const LoopOptions& options, StopSignal& stop);

/// @param expected  shared memory or UDP, as ChooseTransport chose.
Finding CheckLoop(const LoopTrial& trial, dds::Transport expected);

/// Tests whether something that an arm needs besides the kernel answers.  Returns in a few words
/// what was found; throws Error.
using Probe = std::function<std::string()>;

/// Probes of the vendors' libraries and services, replaceable so that a test needs none of them.
struct ArmProbes {
  Probe openhaptics;     ///< loads the library
  Probe forcedimension;  ///< loads the library
  Probe haply;           ///< connects to the service
};
ArmProbes RealArmProbes();

/// Checks whether palpate-station --device could open the device.
/// @param device  a known name, as after --device; if empty, no device is named and a missing one
///                is no fault.
Finding CheckDevice(const HostFiles& host, const std::string& device, const ArmProbes& probes);

/// Opens an arm by a user's own driver and runs it for some seconds as a station does, behind the
/// limiter.  Checks that every call and reading is valid and in time.  Commands no force unless
/// `push`: then 1 N forwards and back along each axis, to see that the handle yields.
std::vector<Finding> TryDriver(const DeviceOptions& options, bool push, StopSignal& stop);

/// Judges whether a handle gives way where it is pushed: not across, not backwards.
/// @param way  motion by a push along x, y and z, as columns [m].
Finding JudgePush(double force_N, const Mat3& way);

/// The wake-up latency of a 1 kHz loop.
struct Jitter {
  Histogram lateness;        ///< [ns]
  std::uint64_t missed = 0;  ///< milliseconds that had passed before the loop woke up for them
};

/// Measures jitter: sleeps until each millisecond of the monotonic clock, in a thread with the
/// rights of a loop.  Throws UsageError if realtime.cpu does not exist.
Jitter MeasureJitter(double seconds, const RealtimeOptions& realtime, StopSignal& stop);

/// Checks whether this jitter leaves enough time to handle a pose.
Finding CheckJitter(const Jitter& jitter);

}  // namespace palpate::doctor
