#pragma once

#include <string>
#include <string_view>

namespace palpate {

enum class LogFormat { kText, kJson };

/// Parses "text" or "json".  Throws UsageError.
LogFormat ParseLogFormat(const std::string& text);

/// Sets the format of SetUpLog and LogLine from now on; the default is text.  A process has one
/// log; every program has the option --log-format.
void SetLogFormat(LogFormat format);

/// Sends spdlog's messages of at least `level` to stderr, one line each ("trace", "debug", "info",
/// "warn", "error", "off"), as "12:34:56.789 palpate-server warning: text", or as an object
/// {"time":"2026-11-25T12:34:56.789Z","level":"warning","program":"palpate-server","message":"text"}
/// (time after RFC 3339, in UTC).  In both formats no message can end its line or control the
/// terminal: see Printable (text/quoted.h).  Standard output is reserved for a program's result.
/// Throws UsageError for an unknown level.  The servo path must call neither this nor anything
/// that logs.
void SetUpLog(const std::string& program, const std::string& level);

/// Returns a program's last message for stderr, with a newline: "palpate-server: text", or the JSON
/// object of a log message of level "error".
std::string LogLine(const std::string& program, std::string_view message);

/// Returns a text made Printable and escaped for a JSON string.
std::string JsonEscaped(std::string_view text);

/// Returns the present time, as "2026-11-25T12:34:56.789Z".
std::string UtcTime();

}  // namespace palpate
