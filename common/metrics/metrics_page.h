#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <prometheus/metric_family.h>

#include "common/metrics/metric.h"

namespace palpate {

/// Collects the values of metrics for one answer.
class MetricsPage {
 public:
  using Labels = std::vector<std::pair<std::string, std::string>>;

  /// Adds a value.  The values of one metric are grouped; metrics keep the order of their
  /// first value.
  void Add(const Metric& metric, double value, const Labels& labels = {});
  void Add(const Metric& metric, std::uint64_t value, const Labels& labels = {}) {
    Add(metric, static_cast<double>(value), labels);
  }
  /// Returns the page in Prometheus's text format.
  std::string ToText() const;

 private:
  std::vector<prometheus::MetricFamily> families_;
};

/// The content type of ToText's text.
inline constexpr char kMetricsContentType[] = "text/plain; version=0.0.4; charset=utf-8";

/// Returns this process's resident memory as the kernel reports it now; 0 if it does not.
std::uint64_t ResidentMemoryBytes();

}  // namespace palpate
