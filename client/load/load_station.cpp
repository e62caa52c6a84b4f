#include "client/load/load_station.h"

#include <spdlog/spdlog.h>

#include "devices/device_factory.h"

namespace palpate {
namespace {

/// How often the progress line has new figures.
constexpr double kSnapshot_s = 0.5;

LinkOptions LinkOf(const std::string& name, const OfferedTool& tool,
                   const LoadRunOptions& options) {
  LinkOptions link;
  link.station = name;
  link.scene = tool.scene;
  link.tool = tool.tool;
  link.device = "scripted (palpate-load)";
  link.domain = options.domain;
  link.transport = options.transport;
  link.network = options.network;
  link.realtime.mode = ParseRealtimeMode(options.realtime);
  link.patience_s = options.patience_s;
  return link;
}

}  // namespace

// Scripted and not simulated: an arm's dynamics are the cost of no real station.
LoadStation::LoadStation(const std::string& name, const OfferedTool& tool, const PoseScript& script,
                         const LoadRunOptions& options)
    : device_(MakeDevice({"scripted", script, true})), core_(*device_) {
  core_.EnableForces(true);
  link_ = std::make_unique<SessionLink>(
      LinkOf(name, tool, options), replies_,
      [this]() -> ServoThread& {
        servo_ = std::make_unique<ServoThread>(core_, replies_, kSnapshot_s);
        return *servo_;
      },
      [name](const std::string& event) { spdlog::debug("{}: {}", name, event); });
}

LoadStation::~LoadStation() {
  link_.reset();  // it tells the loop that there is no path any more
}

void LoadStation::Poll(std::int64_t now_ns) {
  link_->Poll(now_ns);
}

}  // namespace palpate
