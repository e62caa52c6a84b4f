#include "common/program/log.h"

#include <chrono>
#include <cstdio>
#include <ctime>
#include <memory>
#include <utility>

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "common/error.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

LogFormat g_format = LogFormat::kText;

/// Formats the message safely, at the one place where log lines are made.
class SafeMessage : public spdlog::custom_flag_formatter {
 public:
  explicit SafeMessage(LogFormat format) : format_(format) {}

  void format(const spdlog::details::log_msg& message, const std::tm&,
              spdlog::memory_buf_t& out) override {
    const std::string_view text(message.payload.data(), message.payload.size());
    const std::string safe = format_ == LogFormat::kJson ? JsonEscaped(text) : Printable(text);
    out.append(safe.data(), safe.data() + safe.size());
  }
  std::unique_ptr<spdlog::custom_flag_formatter> clone() const override {
    return std::make_unique<SafeMessage>(format_);
  }

 private:
  LogFormat format_;
};

std::unique_ptr<spdlog::formatter> Formatter(LogFormat format) {
  const bool json = format == LogFormat::kJson;
  auto formatter = std::make_unique<spdlog::pattern_formatter>(
      json ? spdlog::pattern_time_type::utc : spdlog::pattern_time_type::local);
  formatter->add_flag<SafeMessage>('*', format);
  formatter->set_pattern(
      json ? R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l","program":"%n","message":"%*"})"
           : "%H:%M:%S.%e %n %^%l%$: %*");
  return formatter;
}

}  // namespace

LogFormat ParseLogFormat(const std::string& text) {
  if (text == "text") return LogFormat::kText;
  if (text == "json") return LogFormat::kJson;
  throw UsageError("--log-format: " + Quoted(text) + " is not known; give text or json");
}

void SetLogFormat(LogFormat format) {
  g_format = format;
}

void SetUpLog(const std::string& program, const std::string& level) {
  const spdlog::level::level_enum parsed = spdlog::level::from_str(level);
  if (parsed == spdlog::level::off && level != "off") {
    throw UsageError("--log-level: '" + level +
                     "' is not known; give trace, debug, info, warn, error or off");
  }
  auto logger = std::make_shared<spdlog::logger>(
      program, std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
  logger->set_formatter(Formatter(g_format));
  logger->set_level(parsed);
  spdlog::set_default_logger(std::move(logger));
}

std::string LogLine(const std::string& program, std::string_view message) {
  if (g_format == LogFormat::kText) return program + ": " + Printable(message) + "\n";
  return R"({"time":")" + UtcTime() + R"(","level":"error","program":")" + JsonEscaped(program) +
         R"(","message":")" + JsonEscaped(message) + "\"}\n";
}

std::string JsonEscaped(std::string_view text) {
  std::string escaped;
  for (const char c : Printable(text)) {
    if (c == '"' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string UtcTime() {
  using namespace std::chrono;
  const auto now = floor<milliseconds>(system_clock::now());
  const std::time_t seconds = system_clock::to_time_t(floor<std::chrono::seconds>(now));
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  char text[40];
  const std::size_t size = std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &parts);
  std::snprintf(text + size, sizeof text - size, ".%03dZ",
                static_cast<int>((now - floor<std::chrono::seconds>(now)).count()));
  return text;
}

}  // namespace palpate
