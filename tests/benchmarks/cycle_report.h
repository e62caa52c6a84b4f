#pragma once

#include <string>

#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/scene_run.h"
#include "tests/support/contact_figures.h"

namespace palpate::bench {

/// How a path is measured; what `cycle` and `hands` have in common.
struct CycleOptions {
  std::string name{};  ///< of the scene, as it was given
  int repeats = 5;
  int check_every = 1;   ///< of the oracles and the converged answer
  int settle_every = 0;  ///< 0: never
  bool quarter_steps = false;
  std::string trace{};  ///< a file; empty: none

  /// Adds the options --repeats, --check-every, --settle-every and --trace.
  void AddTo(const CommandLine& command);
};

/// Measures a path and prints its table.
/// @returns the JSON object that DESIGN.md says.
Json ReportCycle(SceneRun& run, const CycleOptions& options);

/// Contact's figures into a table, where one is given, and a JSON object.
void AddContact(const test::ContactFigures& figures, const CycleOptions& options, Table* table,
                Json& json);

/// Its contact alone, without times.
test::ContactFigures MeasureContact(SceneRun& run, const CycleOptions& options);

}  // namespace palpate::bench
