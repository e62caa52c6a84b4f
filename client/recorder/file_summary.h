#pragma once

#include <string>

#include "common/recording/file_summary.h"

namespace palpate {

std::string ToText(const FileSummary& summary);
/// @param file  "-" is stdout.  Throws Error.
void WriteJson(const FileSummary& summary, const std::string& file);

}  // namespace palpate
