#include "client/doctor/report.h"

#include <algorithm>
#include <array>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "common/text/wrapped.h"

namespace palpate::doctor {
namespace {

// Columns: "  warning  real-time throttling  text".
constexpr int kStatusWidth = 7;
constexpr int kCheckWidth = 20;
constexpr int kTextColumn = 2 + kStatusWidth + 2 + kCheckWidth + 2;
constexpr int kLeastTextWidth = 30;

constexpr std::array kQuantiles = {0.5, 0.99, 0.999, 1.0};

std::string Coloured(const char* code, const std::string& text, const Style& style) {
  return style.colours ? fmt::format("\x1b[{}m{}\x1b[0m", code, text) : text;
}

/// The words for each status.
struct Words {
  const char *name, *colour, *verdict;
};
constexpr Words kWords[] = {
    {"ok", "32", "fit"}, {"warning", "33", "fit, with warnings"}, {"fault", "1;31", "not fit"}};
const Words& Of(Status status) {
  return kWords[static_cast<int>(status)];
}

double Quantile_us(const Jitter& jitter, double q) {
  return 1e-3 * static_cast<double>(jitter.lateness.Quantile(q));
}

std::string Table(const Jitter& jitter) {
  std::string text =
      fmt::format("\n  lateness of a 1 kHz loop over {} cycles [us]\n", jitter.lateness.count());
  text += fmt::format("  {:>10}{:>10}{:>10}{:>10}\n", "p50", "p99", "p99.9", "max");
  text += "  ";
  for (const double q : kQuantiles) text += fmt::format("{:>10.1f}", Quantile_us(jitter, q));
  return text + "\n";
}

}  // namespace

const char* Verdict(const Report& report) {
  return Of(Worst(report.findings)).verdict;
}

std::string ToText(const Finding& finding, const Style& style) {
  const int width = std::max(kLeastTextWidth, style.columns - kTextColumn);
  const Words& words = Of(finding.status);
  std::string text =
      "  " + Coloured(words.colour, fmt::format("{:<{}}", words.name, kStatusWidth), style) +
      fmt::format("  {:<{}}  ", finding.check, kCheckWidth);
  std::string indent;
  for (const std::string& line : Wrapped(finding.found, width)) {
    text += indent + line + "\n";
    indent.assign(kTextColumn, ' ');
  }
  std::string begin = "-> ";
  if (finding.remedy.empty()) return text;
  for (const std::string& line : Wrapped(finding.remedy, width - 3)) {
    text += std::string(kTextColumn, ' ') + Coloured("36", begin + line, style) + "\n";
    begin = "   ";
  }
  return text;
}

std::string Summary(const Report& report, const Style& style) {
  const auto count = [&](Status status) {
    return std::ranges::count(report.findings, status, &Finding::status);
  };
  const auto counted = [](std::ptrdiff_t number, const char* one) {
    return fmt::format("{} {}{}", number, one, number == 1 ? "" : "s");
  };
  std::string text = report.jitter ? Table(*report.jitter) : "";
  text += "\n" +
          Coloured(Of(Worst(report.findings)).colour,
                   std::string("verdict: ") + Verdict(report) + " for 1 kHz", style) +
          " (" + counted(count(Status::kFault), "fault") + ", " +
          counted(count(Status::kWarning), "warning") + ")";
  if (!report.jitter) text += "; the lateness of a loop was not measured";
  return text + "\n";
}

std::string ToJson(const Report& report) {
  nlohmann::ordered_json json;
  json["host"] = report.host;
  json["version"] = PALPATE_VERSION;
  json["findings"] = nlohmann::ordered_json::array();
  for (const Finding& finding : report.findings) {
    json["findings"].push_back({{"check", finding.check},
                                {"status", Of(finding.status).name},
                                {"found", finding.found},
                                {"remedy", finding.remedy}});
  }
  if (report.jitter) {
    json["jitter"] = {{"wake_ups", report.jitter->lateness.count()},
                      {"missed", report.jitter->missed},
                      {"p50_us", Quantile_us(*report.jitter, 0.5)},
                      {"p99_us", Quantile_us(*report.jitter, 0.99)},
                      {"p999_us", Quantile_us(*report.jitter, 0.999)},
                      {"max_us", Quantile_us(*report.jitter, 1.0)}};
  }
  json["verdict"] = Verdict(report);
  // Text from elsewhere, such as a kernel's file, need not be UTF-8.
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace palpate::doctor
