#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/metrics/metrics_page.h"

namespace palpate {

/// Where metrics are to be had: http://ADDRESS:PORT/metrics.
struct MetricsEndpoint {
  std::string address = "127.0.0.1";  ///< in numbers, of IPv6 without brackets
  int port = 0;                       ///< 0: a free one
};

/// "[ADDRESS:]PORT", an address of IPv6 in brackets, as [::1]:9464; without an address this host's
/// own alone.  Throws UsageError.
MetricsEndpoint ParseMetricsEndpoint(const std::string& text);

/// Gives metrics to who asks over HTTP.  Nobody who asks is believed or waited for: a request names
/// a Host that is this one's (common/http/host_name.h), has no more than 8 kB and 5 s, is answered
/// once and its connection closed; of 32 connections, half of them at most of one address from
/// elsewhere, the one that has waited longest makes room for a newcomer.
/// It has one thread, which is started here and so should not be in a servo loop's; nothing that it
/// does meets one.
class MetricsPort {
 public:
  struct Options {
    MetricsEndpoint endpoint;
    std::vector<std::string> host_names = {};  ///< besides addresses, in small letters
    std::string program = "palpate-server";    ///< whose --host-name takes more
  };
  /// @param fill  makes the page; called from the thread of this object.
  /// Throws Error where the port cannot be had.
  MetricsPort(Options options, std::function<void(MetricsPage&)> fill);
  ~MetricsPort();
  MetricsPort(const MetricsPort&) = delete;
  MetricsPort& operator=(const MetricsPort&) = delete;

  /// http://127.0.0.1:9464/metrics, http://[::1]:9464/metrics
  const std::string& url() const { return url_; }

 private:
  class Service;
  class Connection;
  std::unique_ptr<Service> service_;
  std::string url_;
};

}  // namespace palpate
