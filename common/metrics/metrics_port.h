#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/metrics/metrics_page.h"

namespace palpate {

/// Where metrics are served: http://ADDRESS:PORT/metrics.
struct MetricsEndpoint {
  std::string address = "127.0.0.1";  ///< numeric; IPv6 without brackets
  int port = 0;                       ///< 0: a free one
};

/// Parses "[ADDRESS:]PORT", with an IPv6 address in brackets, as [::1]:9464; without an address the
/// port is open to this host alone.  Throws UsageError.
MetricsEndpoint ParseMetricsEndpoint(const std::string& text);

/// Serves metrics over HTTP.  It neither trusts nor waits for clients: a request must name this
/// host in its Host header (common/http/host_name.h) and has at most 8 kB and 5 s; it gets one
/// answer, and the connection is closed.  There are at most 32 connections, at most half of them
/// from one remote address; a newcomer displaces the one that has waited longest.
/// Starts one thread, so do not create it in a servo loop's thread; it never interacts with a
/// servo loop.
class MetricsPort {
 public:
  struct Options {
    MetricsEndpoint endpoint = {};
    std::vector<std::string> host_names = {};  ///< accepted besides addresses, in lower case
    std::string program = "palpate-server";    ///< the program whose --host-name allows more names
  };
  /// @param fill  fills the page; called from this object's thread.
  /// Throws Error if the port cannot be opened.
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
