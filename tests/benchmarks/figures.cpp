#include "tests/benchmarks/figures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "common/files/output.h"

namespace palpate::bench {

Percentiles PercentilesOf(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto rank = [&](double q) {
    const auto n = static_cast<double>(values.size());
    const auto i = static_cast<std::size_t>(std::max(1.0, std::ceil(q * n)));
    return values[i - 1];
  };
  return {rank(0.5), rank(0.99), rank(0.999), values.back()};
}

Json ToJson(const Percentiles& p) {
  return {{"p50", p.p50}, {"p99", p.p99}, {"p999", p.p999}, {"max", p.max}};
}

void BestOf::Add(const std::vector<double>& run) {
  all_.insert(all_.end(), run.begin(), run.end());
  if (best_.empty()) best_ = run;
  for (std::size_t i = 0; i < best_.size(); ++i) best_[i] = std::min(best_[i], run[i]);
}

void Table::Row(const std::string& name, const std::string& unit, const Percentiles& p) {
  const auto number = [](double v) {
    const double a = std::abs(v);
    const int digits = a >= 1000.0 ? 0 : a >= 10.0 ? 1 : 3;
    return fmt::format("{:.{}f}", v, digits);
  };
  lines_.push_back(fmt::format("  {:<22} {:>10} {:>10} {:>10} {:>10}  {}", name, number(p.p50),
                               number(p.p99), number(p.p999), number(p.max), unit));
}

void Table::Line(const std::string& name, const std::string& text) {
  lines_.push_back(fmt::format("  {:<22} {}", name, text));
}

void Table::Print() const {
  std::string out = title_ + "\n";
  out += fmt::format("  {:<22} {:>10} {:>10} {:>10} {:>10}\n", "", "p50", "p99", "p99.9", "max");
  for (const std::string& line : lines_) out += line + "\n";
  // Stdout may carry the JSON object.
  std::fputs(out.c_str(), stderr);
}

void Progress(const std::string& line) {
  static const bool terminal = isatty(STDERR_FILENO) != 0;
  if (terminal) fmt::print(stderr, "\r\033[K{}", line);
}

void WriteJson(const std::string& file, const Json& json) {
  WriteOutput("--json", file, json.dump(2) + "\n");
}

}  // namespace palpate::bench
