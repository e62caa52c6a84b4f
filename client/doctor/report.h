#pragma once

#include "client/doctor/checks.h"

namespace palpate::doctor {

struct Report {
  std::string host{};  ///< name, processor and cores, in a line
  std::vector<Finding> findings{};
  std::optional<Jitter> jitter{};  ///< present if it was measured
};

/// Returns "fit", "fit, with warnings" or "not fit".
const char* Verdict(const Report& report);

struct Style {
  bool colours = false;
  int columns = 100;  ///< of the terminal
};
/// Returns the text of a finding, with its remedy below it.
std::string ToText(const Finding& finding, const Style& style);
/// Returns the text after all findings: the table of wake-up latency and the verdict.
std::string Summary(const Report& report, const Style& style);
std::string ToJson(const Report& report);

}  // namespace palpate::doctor
