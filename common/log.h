#pragma once

#include <string>

namespace palpate {

/// Sends spdlog's output to stderr, as "12:34:56.789 palpate-server warning: text", from `level` on
/// ("trace", "debug", "info", "warn", "error", "off").  Standard output stays for what a program
/// prints as its result.  Throws UsageError for a level that does not exist.
/// Never called from the servo path, nor is anything that logs.
void SetUpLog(const std::string& program, const std::string& level);

}  // namespace palpate
