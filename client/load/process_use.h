#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace palpate {

/// What a process has used of the processor up to a moment, from /proc.
struct ProcessTimes {
  struct Thread {
    std::string name;
    double cpu_s = 0.0;
  };
  std::int64_t time_ns = 0;  ///< steady clock
  double cpu_s = 0.0;        ///< of all threads, those that have ended too
  std::map<int, Thread> threads;
};
/// Nothing where there is no such process.
std::optional<ProcessTimes> TimesOf(int pid);

/// What it used from one moment to another, in fractions of one core.
struct ProcessUse {
  double cpu = 0.0;
  double busiest_thread = 0.0;
  std::string busiest_name;
};
ProcessUse UseBetween(const ProcessTimes& begin, const ProcessTimes& end);

/// A line of /proc/.../stat: its name, and user and system time [clock ticks].
struct StatLine {
  std::string name;
  std::uint64_t ticks = 0;
};
std::optional<StatLine> ParseStatLine(const std::string& line);

/// What all cores did up to a moment [clock ticks].
struct MachineTimes {
  std::uint64_t busy = 0, all = 0;
};
/// Of the text of /proc/stat.
MachineTimes ParseMachineTimes(const std::string& stat);
MachineTimes MachineTimesNow();
/// Of all cores, 0 to 1.
double BusyBetween(const MachineTimes& begin, const MachineTimes& end);

/// /proc/loadavg's first three.
std::string LoadAverages();

/// The palpate-server of the domain; nothing where none runs that this user may look at.
std::optional<int> ServerOf(int domain);
/// The process of this user that listens at a TCP port of this host.
std::optional<int> ListenerAt(int port);

}  // namespace palpate
