#pragma once

#include <string>

#include "tests/benchmarks/pareto_results.h"

namespace palpate::bench {

/// Writes the measurements so far to `folder`/pareto.json, or peers.json if only peers were
/// measured. Throws Error if it cannot.
void WritePareto(const std::string& folder, const ParetoResults& results);

/// Runs pareto_report.py, which makes report.md, the table and the picture from WritePareto's file.
/// Returns false if that failed; the script has then printed the reason.
bool ReportPareto(const std::string& folder, const ParetoResults& results);

}  // namespace palpate::bench
