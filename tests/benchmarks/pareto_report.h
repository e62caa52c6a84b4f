#pragma once

#include <string>

#include "tests/benchmarks/pareto_results.h"

namespace palpate::bench {

/// Writes what has been measured so far: `folder`/report.md, pareto.json, and pareto.csv, from
/// which plots.py draws the pareto.svg that the report shows.  Throws Error where a file cannot be
/// written.
void WritePareto(const std::string& folder, const ParetoResults& results);

}  // namespace palpate::bench
