#include "common/metrics/metrics_port.h"

#include <charconv>
#include <exception>
#include <utility>

#include <prometheus/collectable.h>
#include <prometheus/exposer.h>

#include "common/error.h"
#include "common/quoted.h"

namespace palpate {
namespace {

/// Prometheus asks from one place; a second may look at the same time.
constexpr std::size_t kThreads = 2;

}  // namespace

class MetricsPort::Source : public prometheus::Collectable {
 public:
  explicit Source(std::function<void(MetricsPage&)> fill) : fill_(std::move(fill)) {}
  std::vector<prometheus::MetricFamily> Collect() const override {
    MetricsPage page;
    fill_(page);
    return page.families();
  }

 private:
  std::function<void(MetricsPage&)> fill_;
};

MetricsEndpoint ParseMetricsEndpoint(const std::string& text) {
  MetricsEndpoint endpoint;
  const std::size_t colon = text.rfind(':');
  const std::string port = colon == std::string::npos ? text : text.substr(colon + 1);
  if (colon != std::string::npos) endpoint.address = text.substr(0, colon);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), endpoint.port);
  const bool is_port = error == std::errc() && end == port.data() + port.size() &&
                       endpoint.port >= 0 && endpoint.port <= 65535;
  if (!is_port || endpoint.address.empty()) {
    throw UsageError("--metrics " + Quoted(text) +
                     ": is no [ADDRESS:]PORT; give one as 9464 or 10.0.0.1:9464");
  }
  return endpoint;
}

MetricsPort::MetricsPort(const MetricsEndpoint& endpoint, std::function<void(MetricsPage&)> fill)
    : source_(std::make_shared<Source>(std::move(fill))) {
  const std::string at = endpoint.address + ":" + std::to_string(endpoint.port);
  try {
    exposer_ = std::make_unique<prometheus::Exposer>(at, kThreads);
  } catch (const std::exception&) {
    throw Error("--metrics " + at +
                ": cannot listen there; is the port taken, or the address not this host's? Give "
                "another");
  }
  exposer_->RegisterCollectable(source_);
  url_ = "http://" + endpoint.address + ":" +
         std::to_string(exposer_->GetListeningPorts().front()) + "/metrics";
}

MetricsPort::~MetricsPort() = default;

}  // namespace palpate
