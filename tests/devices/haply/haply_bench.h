#pragma once

#include <cstdlib>
#include <functional>
#include <string>

#include "common/realtime/steady_clock.h"
#include "devices/haply/haply_device.h"
#include "tests/devices/arm_bench.h"
#include "tests/devices/haply/fake_inverse_service.h"
#include "tests/support/eventually.h"

namespace palpate::test {

/// Options for a device of `service`, whose address also goes into the environment.
inline DeviceOptions OptionsOf(const FakeInverseService& service, const std::string& id = "") {
  setenv(haply::kServiceVariable, ("ws://127.0.0.1:" + service.address().port).c_str(), 1);
  DeviceOptions options;
  options.arm = id;
  options.realtime.mode = RealtimeMode::kOff;
  return options;
}

/// Ticks by the real clock, as the service's thread does.
struct HaplyBench : AnsweredArm<HaplyDevice> {
  explicit HaplyBench(const FakeInverseService& service) : AnsweredArm(OptionsOf(service)) {
    wrench.force = Vec3(0.0, 1.0, 0.0);
  }

  void Tick() {
    AnsweredArm::Tick(SteadyNanoseconds());
    if (++ticks % 10 == 0) Attend();
  }
  bool Until(const std::function<bool()>& so) {
    return Eventually([&] {
      if (so()) return true;
      Tick();
      return false;
    });
  }
  bool UntilForce() {
    return Until([this] { return arm.sent_force().norm() > 0.9 * wrench.force.norm(); });
  }
  bool UntilNews(const std::string& text) {
    return Until([&] { return news.find(text) != std::string::npos; });
  }

  int ticks = 0;
};

}  // namespace palpate::test
