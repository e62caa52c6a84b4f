#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/load/load_figures.h"
#include "common/program/machine.h"

namespace palpate {

/// A largest load.
struct Capacity {
  std::size_t holds = 0;  ///< 0: not even one
  /// The least that was seen not to hold; 0: all there was to try held.
  std::size_t fails = 0;
};

/// The largest n of 1 to `most` that holds, where what is less than that holds, too: by doubling,
/// then bisection.  A load that does not hold is tried `attempts` times, because a machine that had
/// something else to do for a moment says no more than that.
/// @param holds  runs a load; what it throws comes through.
Capacity FindCapacity(std::size_t most, int attempts,
                      const std::function<bool(std::size_t n)>& holds);

/// A largest load, and the runs that show it.
struct FoundLoad {
  Capacity capacity;
  std::optional<LoadFigures> held;    ///< of capacity.holds
  std::optional<LoadFigures> failed;  ///< of capacity.fails, where that was run
  std::string refusal;  ///< of capacity.fails, where server or gateway did not take it
};

/// FindCapacity by runs that Holds() judges.
/// @param run  figures of n; nothing: it was stopped.  Where less has held, its Error means that
///             server or gateway do not take n, nor more; before that it comes through.
FoundLoad FindLoad(std::size_t most, int attempts,
                   const std::function<std::optional<LoadFigures>(std::size_t n)>& run);

/// What runs have shown, as a document.
struct CapacityReport {
  HostMachine machine;
  std::string time;  ///< when it was begun, UTC
  std::string command;
  std::string scene;
  std::string realtime;  ///< what the stations' loops were granted
  std::vector<LoadFigures> runs;
  std::vector<std::string> limits;  ///< sentences that a search has ended with
};

/// One line of the table for each run, without its heading.
std::string TableRow(const LoadFigures& figures);
/// Markdown.
std::string ToMarkdown(const CapacityReport& report);

}  // namespace palpate
