#pragma once

#include <string>

#include "tests/benchmarks/pareto_results.h"

namespace palpate::bench {

/// Writes what has been measured so far: `folder`/report.md, pareto.json, pareto.svg (light or dark
/// as its reader prefers) and pareto-light.svg and pareto-dark.svg, which the report shows.  Throws
/// Error where a file cannot be written.
void WritePareto(const std::string& folder, const ParetoResults& results);

}  // namespace palpate::bench
