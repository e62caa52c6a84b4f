#pragma once

#include <cstdio>
#include <string>

#include "client/replayer/score/score_report.h"
#include "common/text/quoted.h"

namespace palpate {

/// Prints a result, a Verification, a Certificate or a Report.
/// @param json  file that it is written to, too; "-": standard output, in place of the text.
template <class Result>
void Show(const Result& result, const std::string& json) {
  if (json != "-") std::fputs(ToText(result).c_str(), stdout);
  if (!json.empty()) WriteJson(result, json);
}

inline void SayToOpen(const std::string& page) {
  std::fprintf(stderr, "open %s\n", ShellWord(page).c_str());
}

inline void ShowReport(const Report& report, const std::string& out, const std::string& json) {
  Show(report, json);
  if (out.empty()) return;
  WriteReport(report, out);
  SayToOpen(out + "/score.html");
}

}  // namespace palpate
