#pragma once

#include <string>

#include "tests/benchmarks/pareto_results.h"

namespace palpate::bench {

/// Writes what has been measured so far: `folder`/report.md, pareto.json, and pareto.csv, from
/// which DrawPareto draws the pareto.svg that the report shows; of peers alone, peers.json and so
/// on.  Throws Error where a file cannot be written.
void WritePareto(const std::string& folder, const ParetoResults& results);

/// Draws the picture of what WritePareto wrote.  False where that failed: plots.py has said why.
bool DrawPareto(const std::string& folder, const ParetoResults& results);

}  // namespace palpate::bench
