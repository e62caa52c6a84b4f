#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/metrics/metrics_page.h"

namespace prometheus {
class Exposer;
}

namespace palpate {

/// Where metrics are to be had: http://ADDRESS:PORT/metrics.
struct MetricsEndpoint {
  std::string address = "127.0.0.1";
  int port = 0;  ///< 0: a free one
};

/// "[ADDRESS:]PORT"; without an address this host's own alone.  Throws UsageError.
MetricsEndpoint ParseMetricsEndpoint(const std::string& text);

/// Gives metrics to who asks over HTTP, with threads of its own.
class MetricsPort {
 public:
  /// @param fill  makes the page; called from threads of this object.
  /// Throws Error where the port cannot be had.
  MetricsPort(const MetricsEndpoint& endpoint, std::function<void(MetricsPage&)> fill);
  ~MetricsPort();
  MetricsPort(const MetricsPort&) = delete;
  MetricsPort& operator=(const MetricsPort&) = delete;

  /// http://127.0.0.1:9464/metrics
  const std::string& url() const { return url_; }

 private:
  class Source;
  std::shared_ptr<Source> source_;
  std::unique_ptr<prometheus::Exposer> exposer_;
  std::string url_;
};

}  // namespace palpate
