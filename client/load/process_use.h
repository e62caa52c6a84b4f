#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace palpate {

/// The processor time that a process has used up to a moment, from /proc.
struct ProcessTimes {
  std::int64_t time_ns = 0;  ///< steady clock
  double cpu_s = 0.0;        ///< of all threads, including ended ones
};
/// Returns nothing if there is no such process.
std::optional<ProcessTimes> TimesOf(int pid);

/// Returns the processor use between two moments, in fractions of one core.
double UseBetween(const ProcessTimes& begin, const ProcessTimes& end);

/// Returns the user plus system time in a line of /proc/.../stat [clock ticks].
std::optional<std::uint64_t> TicksOf(const std::string& line);

/// The time that all cores together spent up to a moment [clock ticks].
struct MachineTimes {
  std::uint64_t busy = 0, all = 0;
};
/// Parses the text of /proc/stat.
MachineTimes ParseMachineTimes(const std::string& stat);
MachineTimes MachineTimesNow();
/// Returns the busy fraction of all cores, 0 to 1.
double BusyBetween(const MachineTimes& begin, const MachineTimes& end);

/// Returns the first three fields of /proc/loadavg.
std::string LoadAverages();

/// Returns the process of the domain's palpate-server; nothing if none runs that this user
/// may inspect.
std::optional<int> ServerOf(int domain);
/// Returns this user's process that listens on a TCP port of this host.
std::optional<int> ListenerAt(int port);

}  // namespace palpate
