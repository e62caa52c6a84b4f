#pragma once

#include <string>
#include <vector>

#include "client/load/load_figures.h"
#include "common/program/machine.h"

namespace palpate {

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
