#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/faults/lab.h"

namespace palpate::faults {

/// Something that goes wrong, and what must be true nevertheless.
struct Fault {
  std::string name;   ///< "server-killed"
  std::string story;  ///< what is done
  std::function<std::vector<Finding>(int domain)> run;
};

// Those that have files of their own.

/// The wall clock of server, station, gateway and recorder, one after the other, goes an hour ahead
/// and back, and an hour back and ahead (tests/faults/clock_shim.cpp).
std::vector<Finding> ClockSteps(int domain);
/// The recorder is killed again and again, at other moments of its work: what it had written is
/// whole, and how much that lacks of what was on the wire.
std::vector<Finding> RecorderKilled(int domain);
/// A /dev/shm of the test's own, in a mount namespace of its own, with an own RouDi: it is full
/// before RouDi and the programs start, or is filled under programs that run.  Where the machine
/// gives no such namespace, the findings say so.
std::vector<Finding> SharedMemoryTooSmall(int domain);
std::vector<Finding> SharedMemoryFills(int domain);

/// All of them, in the order of the table.
const std::vector<Fault>& AllFaults();

/// Kills, freezes and starts again what a seed says, one after another, and looks at the same
/// things at the end.
std::vector<Finding> RandomFaults(int domain, std::uint64_t seed, int rounds);

}  // namespace palpate::faults
