#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/load/load_figures.h"
#include "common/program/machine.h"

namespace palpate {

/// The largest load that holds.
struct Capacity {
  std::size_t holds = 0;  ///< 0: not even one holds
  /// The smallest load seen to fail; 0: every load tried held.
  std::size_t fails = 0;
};

/// Finds the largest n from 1 to `most` that holds, by doubling and then bisection; assumes that
/// every smaller load holds too.  Tries a load that fails up to `attempts` times, since one failure
/// may only mean that the machine was busy for a moment.
/// @param holds  runs a load; its exceptions pass through.
Capacity FindCapacity(std::size_t most, int attempts,
                      const std::function<bool(std::size_t n)>& holds);

/// The largest load, with the runs that show it.
struct FoundLoad {
  Capacity capacity;
  std::optional<LoadFigures> held;    ///< figures at capacity.holds
  std::optional<LoadFigures> failed;  ///< figures at capacity.fails, if that was run
  std::string refusal;                ///< why server or gateway refused capacity.fails, if they did
};

/// Runs FindCapacity with loads that Holds() judges.
/// @param run  returns the figures of n; nothing if it was stopped.  After a smaller load has held,
///             an Error from it means that server or gateway accept neither n nor more; before
///             that, the Error passes through.
FoundLoad FindLoad(std::size_t most, int attempts,
                   const std::function<std::optional<LoadFigures>(std::size_t n)>& run);

/// The results of several runs, as a document.
struct CapacityReport {
  HostMachine machine;
  std::string time;  ///< UTC time at which it began
  std::string command;
  std::string scene;
  std::string realtime;  ///< real-time rights that the stations' loops were granted
  std::vector<LoadFigures> runs;
  std::vector<std::string> limits;  ///< one sentence for the end of each search
};

/// Returns a line of the table for one run, without the heading.
std::string TableRow(const LoadFigures& figures);
/// Returns the report as Markdown.
std::string ToMarkdown(const CapacityReport& report);

}  // namespace palpate
