#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "client/station/station_core.h"
#include "common/time/steady_clock.h"
#include "devices/haply/haply_device.h"
#include "devices/wrench_limiter.h"
#include "tests/devices/haply/fake_inverse_service.h"

namespace palpate::test {

/// The driver with a station behind it whose server always answers with one wrench; a tick each
/// millisecond of the real clock, as the service's thread is real.
class HaplyBench {
 public:
  explicit HaplyBench(const FakeInverseService& service)
      : arm({.device_id = "",
             .rate_Hz = 1000.0,
             .service = service.address(),
             .realtime = {RealtimeMode::kOff}}) {}

  void Tick() {
    const std::int64_t now = SteadyNanoseconds();
    const OutgoingPose pose = core.Sense(now, true);
    sample = pose.sample;
    // As a station does with a device at fault.
    core.EnableForces((sample.status & kDeviceFault) == 0);
    Reply reply;
    reply.pose_sequence = pose.sequence;
    reply.pose_time_ns = reply.received_ns = now;
    reply.wrench = wrench;
    core.Take(reply);
    core.Act(now);
    if (++ticks % 10 == 0) {
      if (const std::string more = arm.Attend(); !more.empty()) news += more + "\n";
    }
  }
  /// Ticks until so; false after a time that is long beside any stall of the machine.
  bool Until(const std::function<bool()>& so, double seconds = 30.0) {
    const std::int64_t end = SteadyNanoseconds() + static_cast<std::int64_t>(1e9 * seconds);
    while (!so()) {
      if (SteadyNanoseconds() > end) return false;
      Tick();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }
  bool UntilForce() {
    return Until([this] { return arm.sent_force().norm() > 0.9 * wrench.force.norm(); });
  }
  bool UntilNews(const std::string& text) {
    return Until([&] { return news.find(text) != std::string::npos; });
  }

  HaplyDevice arm;
  StationCore core{arm};
  Wrench wrench{Vec3(0.0, 1.0, 0.0), Vec3(0.0, 0.0, 0.03)};
  DeviceSample sample;
  std::string news;
  int ticks = 0;
};

}  // namespace palpate::test
