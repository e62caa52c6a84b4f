#pragma once

#include <string>

#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/scene_run.h"
#include "tests/support/contact_figures.h"

namespace palpate::bench {

/// How to measure a path: options that `cycle` and `hands` have in common.
struct CycleOptions {
  std::string name{};  ///< the scene's name, as given
  int repeats = 5;
  int check_every = 1;   ///< interval [steps] of the oracles and of the converged answer
  int settle_every = 0;  ///< 0: never
  int judge_every = 10;  ///< 0: never
  bool quarter_steps = false;
  std::string trace{};  ///< output file; empty: none

  /// Adds the options --repeats, --check-every, --settle-every, --judge-every and
  /// --trace.
  void AddTo(const CommandLine& command);
};

/// Measures a path and prints its table.
/// @returns its JSON object.
Json ReportCycle(SceneRun& run, const CycleOptions& options);

/// Adds the figures of contact to a table, if given, and to a JSON object.
void AddContact(const test::ContactFigures& figures, const CycleOptions& options, Table* table,
                Json& json);

/// Measures only the contact, without times.
test::ContactFigures MeasureContact(SceneRun& run, const CycleOptions& options);

}  // namespace palpate::bench
