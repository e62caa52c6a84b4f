#include "common/metrics/metrics_page.h"

#include <algorithm>
#include <fstream>

#include <prometheus/text_serializer.h>
#include <unistd.h>

#include "common/text/quoted.h"

namespace palpate {

void MetricsPage::Add(const Metric& metric, double value, const Labels& labels) {
  const bool counts = metric.kind == Metric::Kind::kCounter;
  auto family = std::ranges::find(families_, metric.name, &prometheus::MetricFamily::name);
  if (family == families_.end()) {
    families_.push_back({metric.name,
                         metric.help,
                         counts ? prometheus::MetricType::Counter : prometheus::MetricType::Gauge,
                         {}});
    family = families_.end() - 1;
  }
  prometheus::ClientMetric& sample = family->metric.emplace_back();
  // Invalid UTF-8 would make the whole page unreadable.
  for (const auto& [name, text] : labels) sample.label.push_back({name, Printable(text)});
  (counts ? sample.counter.value : sample.gauge.value) = value;
}

std::string MetricsPage::ToText() const {
  return prometheus::TextSerializer().Serialize(families_);
}

std::uint64_t ResidentMemoryBytes() {
  std::uint64_t size = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> size >> resident;
  return resident * static_cast<std::uint64_t>(getpagesize());
}

}  // namespace palpate
