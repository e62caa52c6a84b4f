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
  kWarning,  ///< holds 1 kHz, less well than it could, or not for everybody
  kFault,    ///< does not hold 1 kHz, or does not work at all
};

/// What one check has to say.
struct Finding {
  std::string check{};  ///< its name, as a script looks for it: "idle states"; Examine gives it
  Status status = Status::kOk;
  std::string found{};
  std::string remedy{};  ///< what to do, with the command or file; empty where it is ok
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

/// How a kernel gets an option, in a remedy's words.
inline std::string GrubLine(const std::string& option) {
  return "add " + option + " to GRUB_CMDLINE_LINUX in /etc/default/grub, run sudo update-grub";
}

/// The worst status of all.
inline Status Worst(const std::vector<Finding>& findings) {
  Status worst = Status::kOk;
  for (const Finding& finding : findings) worst = std::max(worst, finding.status);
  return worst;
}

/// How soon the kernel lets a real-time thread in: PREEMPT_RT, else its mode of preemption.
Finding CheckKernel(const HostFiles& host);
/// Whether the clock is read without a system call.
Finding CheckClockSource(const HostFiles& host);

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

/// What RouDi needs in /dev/shm with the project's pools; a test compares it with them.
inline constexpr long long kSharedMemoryNeeded_MB = 117;

struct Space {
  long long size_MB = 0;
  long long free_MB = 0;
};
/// Of the file system that the folder is on; nothing where there is no such folder.
std::optional<Space> SpaceIn(const HostFiles& host, const std::string& folder);

/// RouDi, the keeper of the shared memory, as this host shows it.
struct RouDiState {
  bool socket = false;   ///< /tmp/roudi is there
  bool answers = false;  ///< and a process holds it open
  /// As a living RouDi holds it, or where that cannot be seen, the socket answers.
  bool lock_held = false;
  /// Its files that are another user's, who alone may start a RouDi while they are there; each with
  /// a space before it.
  std::string closed{};
  long long owner = -1;                ///< user id of the socket's owner
  bool may_connect = false;            ///< this user may open the socket
  std::optional<std::string> pools{};  ///< file that it was started with; "" without one
};
RouDiState LookAtRouDi(const HostFiles& host);

/// @param wanted  kUdp: it is not needed.
Finding CheckSharedMemory(const std::optional<Space>& space, bool roudi_runs,
                          dds::Transport wanted);
/// @param pools  file to start it with, for the remedy.
Finding CheckRouDi(const RouDiState& roudi, dds::Transport wanted, long long user,
                   const std::string& pools);

/// A network interface with an address of IPv4.
struct Interface {
  std::string name;
  bool up = false;
  bool multicast = false;
};
std::vector<Interface> InterfacesOfThisHost();

/// Whether programs can meet over --network.
Finding CheckNetwork(const std::vector<Interface>& interfaces, const dds::Network& network);

/// Whether the UDP ports of --domain are free, or a palpate-server's.
/// @param server_runs  in this domain, on this host.
Finding CheckPorts(const HostFiles& host, int domain, bool server_runs);
/// A palpate-server of this host has this domain.
bool ServerRuns(const HostFiles& host, int domain);

/// What two processes found that sent poses and echoed wrenches as a station and a server do. Plain
/// data: it comes through a pipe.
struct LoopTrial {
  bool finished = false;  ///< all below counts
  bool shared_memory = false;
  std::uint64_t sent = 0;
  std::uint64_t lost = 0;
  double p50_us = 0.0;  ///< round trip
  double p99_us = 0.0;
  double max_us = 0.0;
  char error[512] = {};  ///< why not finished; empty where it hung or died
};

struct LoopOptions {
  int domain = 0;
  dds::Transport transport = dds::Transport::kAuto;
  dds::Network network{};
  RealtimeOptions realtime{};
};

/// Tries it for about a second, in two processes of its own, which a hanging RouDi, or a library
/// that aborts, may take with it.  To be called while this process has no other thread.
/// @param stop  ends it early; made before, so that both processes see a signal, too.
LoopTrial TryLoop(const LoopOptions& options, StopSignal& stop);

/// @param expected  shared memory, or UDP, as ChooseTransport chose.
Finding CheckLoop(const LoopTrial& trial, dds::Transport expected);

/// Whether what an arm needs beside the kernel answers: what was found, in a few words; throws
/// Error.
using Probe = std::function<std::string()>;

/// Of the vendors' libraries and services, so that a test needs none of them.
struct ArmProbes {
  Probe openhaptics;     ///< loads the library
  Probe forcedimension;  ///< loads the library
  Probe haply;           ///< connects to the service
};
ArmProbes RealArmProbes();

/// Whether palpate-station --device could open the device.
/// @param device  as after --device, known; empty: none is named, and what is missing is no fault.
Finding CheckDevice(const HostFiles& host, const std::string& device, const ArmProbes& probes);

/// Opens an arm by a driver of one's own, and has it do for some seconds what a station does,
/// behind the limiter: whether every call and reading is in order, and in time.  Without a force,
/// but where it is to `push`: 1 N there and back along each axis, to see that the handle gives way.
std::vector<Finding> TryDriver(const DeviceOptions& options, bool push, StopSignal& stop);

/// How late a loop of 1 kHz woke up.
struct Jitter {
  Histogram lateness;        ///< [ns]
  std::uint64_t missed = 0;  ///< milliseconds that had passed before the loop woke up for them
};

/// Sleeps until each millisecond of the monotonic clock, in a thread with the rights of a loop.
/// Throws UsageError where realtime.cpu does not exist.
Jitter MeasureJitter(double seconds, const RealtimeOptions& realtime, StopSignal& stop);

/// Whether that leaves a pose its time.
Finding CheckJitter(const Jitter& jitter);

}  // namespace palpate::doctor
