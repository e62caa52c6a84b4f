#pragma once

#include <cstdint>
#include <string>

#include "client/viewer/viewers.h"

namespace palpate {

class Hub;
class TopicFeed;

/// Returns the answer to GET /healthz.
std::string HealthOf(Hub& hub);
/// Returns the answer to GET /metrics, for Prometheus.
std::string MetricsOf(Hub& hub);

/// Logs how much the gateway carries, every five seconds.
class StatisticsLog {
 public:
  StatisticsLog();
  void Poll(const Viewers& viewers, const TopicFeed& feed, std::int64_t now_ns);

 private:
  Viewers::Traffic logged_;
  std::int64_t logged_ns_;
};

}  // namespace palpate
