#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <prometheus/metric_family.h>

#include "common/metrics/metric.h"

namespace palpate {

/// Values of metrics on their way to who asks for them.
class MetricsPage {
 public:
  using Labels = std::vector<std::pair<std::string, std::string>>;

  /// Values of one metric stand together, in the order in which the metrics first come.
  void Add(const Metric& metric, double value, const Labels& labels = {});
  void Add(const Metric& metric, std::uint64_t value, const Labels& labels = {}) {
    Add(metric, static_cast<double>(value), labels);
  }
  /// In Prometheus's text format.
  std::string ToText() const;

 private:
  std::vector<prometheus::MetricFamily> families_;
};

/// The content type of ToText's text.
inline constexpr char kMetricsContentType[] = "text/plain; version=0.0.4; charset=utf-8";

/// Of this process, as the kernel counts it now; 0 where it does not tell.
std::uint64_t ResidentMemoryBytes();

}  // namespace palpate
