#pragma once

#include <cstdint>
#include <string>

#include "client/viewer/mouse_room.h"
#include "client/viewer/topic_feed.h"
#include "client/viewer/viewers.h"

namespace palpate {

/// Returns the answer to GET /healthz.
std::string HealthOf(Viewers& viewers, const TopicFeed& feed, const MouseRoom& mice);
/// Returns the answer to GET /metrics, for Prometheus.
std::string MetricsOf(Viewers& viewers, const TopicFeed& feed, const MouseRoom& mice);

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
