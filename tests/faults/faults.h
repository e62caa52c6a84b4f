#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/faults/lab.h"

namespace palpate::faults {

/// A fault, and what must hold nevertheless.
struct Fault {
  std::string name;   ///< "server-killed"
  std::string story;  ///< what is done
  std::function<std::vector<Finding>(int domain)> run;
};

// Faults with files of their own.

/// The wall clock of server, station, gateway and recorder, one after the other, jumps an hour
/// ahead and back, and an hour back and ahead (tests/faults/clock_shim.cpp).
std::vector<Finding> ClockSteps(int domain);
/// The recorder is killed again and again, at different moments of its work: what it wrote is
/// whole, and how much of what was on the wire it lacks is measured.
std::vector<Finding> RecorderKilled(int domain);
/// A /dev/shm of the test's own, in a mount namespace with a RouDi of its own: full before RouDi
/// and the programs start, or filled while they run.  Where the machine allows no such namespace,
/// the findings say so.
std::vector<Finding> SharedMemoryTooSmall(int domain);
std::vector<Finding> SharedMemoryFills(int domain);

/// All faults, in the order of the table.
const std::vector<Fault>& AllFaults();

/// Kills, freezes and restarts programs as the seed says, one after another, and checks the same
/// things at the end.
std::vector<Finding> RandomFaults(int domain, std::uint64_t seed, int rounds);

}  // namespace palpate::faults
