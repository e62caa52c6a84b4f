#pragma once

#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "client/station/guide_link.h"
#include "client/station/servo_thread.h"
#include "client/station/session_link.h"
#include "client/station/station_core.h"
#include "common/dds/topics.h"
#include "common/realtime/steady_clock.h"
#include "devices/device.h"
#include "devices/wrench_limiter.h"
#include "tests/support/eventually.h"
#include "tests/support/program.h"
#include "tests/support/test_domain.h"

// The real palpate-server with scene `cube`, and stations to drive it.
namespace palpate::test {

inline const int kDomain = OwnDomain();
constexpr std::int64_t kSecond_ns = 1'000'000'000;
/// 1 mm deep at 1 N/mm.
constexpr double kDepth_m = 0.001;
constexpr double kForce_N = 1.0;

/// palpate-server, which says when it is ready.
class ServerProgram : public Program {
 public:
  explicit ServerProgram(const std::string& transport,
                         const std::vector<std::string>& scenes = {"cube"})
      : Program(PALPATE_BIN_DIR "/palpate-server",
                Joined(scenes, {"--realtime", "off", "--transport", transport, "--domain",
                                std::to_string(kDomain)})) {}
  bool Ready() { return Says("ready: ", 60.0) && Says("\n"); }
};

/// palpate-station with a ball pressed on the cube.
class StationProgram : public Program {
 public:
  StationProgram(const std::string& id, const std::string& transport,
                 const std::vector<std::string>& more = {})
      : Program(
            PALPATE_BIN_DIR "/palpate-station",
            Joined({"--device", "scripted", "--scene", "cube", "--id", id, "--script",
                    PALPATE_SOURCE_DIR "/tests/integration/press.json", "--no-table", "--realtime",
                    "off", "--transport", transport, "--domain", std::to_string(kDomain)},
                   more)) {}
};

/// A device held 1 mm deep in the cube's top face, which shows the force that it renders.
class HeldDevice final : public Device {
 public:
  HeldDevice() {
    info_.model = "held";
    info_.max_force_N = 22.0;
    info_.continuous_force_N = 3.0;
    info_.max_torque_Nm = 0.515;
    info_.continuous_torque_Nm = 0.188;
    sample_.X_WH.p = Vec3(0.0, 0.030 - kDepth_m, 0.0);
  }
  const DeviceInfo& info() const override { return info_; }
  DeviceSample Read() noexcept override { return sample_; }
  void Apply(const LimitedWrench& wrench) noexcept override {
    force_N = wrench.wrench().force.norm();
  }

  std::atomic<double> force_N{0.0};

 private:
  DeviceInfo info_;
  DeviceSample sample_;
};

/// A whole palpate-station except for main, in this process, so that the force of each millisecond
/// can be seen.
class HeldStation {
 public:
  HeldStation() {
    core_.EnableForces(true);
    LinkOptions options;
    options.station = "held";
    options.scene = "cube";
    options.domain = kDomain;
    options.transport = dds::Transport::kUdp;
    options.realtime.mode = RealtimeMode::kOff;
    link_ = std::make_unique<SessionLink>(
        options, replies_,
        [this]() -> ServoThread& {
          servo_ = std::make_unique<ServoThread>(core_, replies_, 0.01);
          return *servo_;
        },
        [](const std::string&) {});
  }
  ~HeldStation() {
    link_.reset();
    servo_->Stop();
  }

  /// Like --accept-guide; to be called before the first Until.
  void AcceptGuide(double force_N) {
    core_.AcceptGuide(GuideLimits::OfForce(force_N));
    guide_.emplace(guides_, "held");
  }
  /// Polls as main does, until the condition holds.
  template <class Condition>
  bool Until(Condition condition, double seconds = 20.0) {
    return Eventually(
        [&] {
          link_->Poll(SteadyNanoseconds());
          if (guide_) guide_->Poll([this](const GuideAim& aim) { servo_->SetAim(aim); });
          return condition();
        },
        seconds);
  }
  bool UntilForce() {
    return Until([this] { return std::abs(device.force_N - kForce_N) < 0.005 * kForce_N; });
  }
  void For(double seconds) {
    Until([] { return false; }, seconds);
  }

  HeldDevice device;

 private:
  StationCore core_{device};
  ReplyRing replies_;
  std::unique_ptr<ServoThread> servo_;
  std::unique_ptr<SessionLink> link_;
  dds::Participant guides_ = dds::Participant::Service(kDomain, {});
  std::optional<GuideLink> guide_;
};

}  // namespace palpate::test
