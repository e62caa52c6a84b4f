#pragma once

#include <string>

#include "tests/benchmarks/pareto_results.h"

namespace palpate::bench {

/// Writes what has been measured so far: `folder`/pareto.json, or peers.json of peers alone.
/// Throws Error where it cannot be written.
void WritePareto(const std::string& folder, const ParetoResults& results);

/// Has pareto_report.py make report.md, table and picture of what WritePareto wrote.  False where
/// that failed: the script has said why.
bool ReportPareto(const std::string& folder, const ParetoResults& results);

}  // namespace palpate::bench
