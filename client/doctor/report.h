#pragma once

#include "client/doctor/checks.h"

namespace palpate::doctor {

struct Report {
  std::string host{};  ///< name, processor and cores, in a line
  std::vector<Finding> findings{};
  std::optional<Jitter> jitter{};  ///< where it was measured
};

/// "fit", "fit, with warnings", "not fit".
const char* Verdict(const Report& report);

struct Style {
  bool colours = false;
  int columns = 100;  ///< of the terminal
};
/// A finding, with its remedy below it.
std::string ToText(const Finding& finding, const Style& style);
/// What comes after all findings: the table of lateness and the verdict.
std::string Summary(const Report& report, const Style& style);
std::string ToJson(const Report& report);

}  // namespace palpate::doctor
