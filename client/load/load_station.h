#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "client/load/options.h"
#include "client/station/reply.h"
#include "client/station/served_tools.h"
#include "client/station/servo_thread.h"
#include "client/station/session_link.h"
#include "client/station/station_core.h"
#include "common/json/pose_script.h"
#include "devices/device.h"

namespace palpate {

/// A palpate-station but for its command line and table: the same core, loop and session, with a
/// hand that follows a script again and again.  Several are threads of one process, for DDS then
/// has one set of threads for all of them (README.md has figures). Thread contract: one thread,
/// that of all stations.
class LoadStation {
 public:
  LoadStation(const std::string& name, const OfferedTool& tool, const PoseScript& script,
              const LoadRunOptions& options);
  ~LoadStation();

  /// A hundred times a second.  Throws Error (SessionLink::Poll).
  void Poll(std::int64_t now_ns);
  bool linked() const { return link_->phase() == SessionLink::Phase::kLinked; }
  ServoThread& servo() { return *servo_; }
  const ServoThread& servo() const { return *servo_; }
  const SessionLink& link() const { return *link_; }
  /// After servo().Stop().
  const StationTotals& totals() const { return core_.totals(); }

 private:
  std::unique_ptr<Device> device_;
  StationCore core_;
  ReplyRing replies_;
  std::unique_ptr<ServoThread> servo_;
  std::unique_ptr<SessionLink> link_;
};

}  // namespace palpate
