#pragma once

#include <string>
#include <string_view>

namespace palpate {

enum class LogFormat { kText, kJson };

/// "text" or "json".  Throws UsageError.
LogFormat ParseLogFormat(const std::string& text);

/// The form of what SetUpLog and LogLine make from then on; text until then.  A process has one
/// log, and --log-format of every program says its form.
void SetLogFormat(LogFormat format);

/// Sends spdlog's output to stderr, a line each, from `level` on ("trace", "debug", "info", "warn",
/// "error", "off"): as "12:34:56.789 palpate-server warning: text", or as an object
/// {"time":"2026-11-25T12:34:56.789Z","level":"warning","program":"palpate-server","message":"text"}
/// (time after RFC 3339, in UTC).  Nothing that a message holds can end its line or command a
/// terminal: see Printable (text/quoted.h), in both forms.  Standard output stays for what a
/// program prints as its result.  Throws UsageError for a level that does not exist. Never called
/// from the servo path, nor is anything that logs.
void SetUpLog(const std::string& program, const std::string& level);

/// A program's last words on stderr, with a newline: "palpate-server: text", or the object that the
/// log would make of it at level "error".
std::string LogLine(const std::string& program, std::string_view message);

/// Printable, and what a JSON string needs besides.
std::string JsonEscaped(std::string_view text);

/// Now, as "2026-11-25T12:34:56.789Z".
std::string UtcTime();

}  // namespace palpate
