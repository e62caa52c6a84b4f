#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "client/station/reply.h"
#include "client/station/station_core.h"
#include "common/dds/wire.h"
#include "server/session/servo_loop.h"
#include "tests/session/ball_tool.h"
#include "tests/station/still_device.h"
#include "tests/support/simulated_link.h"

namespace palpate::test {

/// A station's core, a server's loop and a link between them, in virtual time: a tick is a
/// millisecond.  The hand is a device held by the test, at first 2 mm deep in a ball of 1 N/mm.
/// The server answers a pose at the instant of its arrival.
class VirtualLoop {
 public:
  static constexpr std::int64_t kTick_ns = 1'000'000;
  static constexpr double kDepth_m = 0.002;

  explicit VirtualLoop(std::uint64_t seed, const LinkConditions& conditions = {})
      : link_(seed, conditions) {
    Press(kDepth_m);
    core_.EnableForces(true);
    StartServer();
  }

  /// Starts a server; poses that are on their way reach it, too.
  void StartServer() {
    server_ = std::make_unique<ServoLoop>(tool_->model);
    server_->Start(Pose{Vec3(0, 0, kTouch), Quat::Identity()});
  }
  /// From now on nobody hears poses.
  void KillServer() { server_.reset(); }
  /// While frozen, the server reads nothing; what comes waits for it.
  void FreezeServer(bool on) { frozen_ = on; }

  void Press(double depth_m) { device_.sample.X_WH.p = Vec3(0, 0, kTouch - depth_m); }
  void Tick() {
    Deliver(now_ns_);
    now_ns_ += kTick_ns;
    Serve();
    Sense();
    Deliver(now_ns_);
    before_ = device_.applied;
    core_.Act(now_ns_);
  }
  void For(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) Tick();
  }

  /// Falsifies the server's answers on their way.
  std::function<void(wire::Wrench&)> forge;

  SimulatedLink<wire::HapticPose, wire::Wrench>& link() { return link_; }
  StationCore& core() { return core_; }
  StillDevice& device() { return device_; }
  std::int64_t now_ns() const { return now_ns_; }
  const Wrench& applied() const { return device_.applied; }
  /// The wrench applied in the tick before.
  const Wrench& before() const { return before_; }

 private:
  void Sense() {
    const OutgoingPose out = core_.Sense(now_ns_, true);
    pose_ = {};
    pose_.pose_sequence = out.sequence;
    pose_.sample_time_ns = out.sample_time_ns;
    wire::FromPose(out.X_WH, pose_.position_m, pose_.orientation_wxyz);
    wire::FromVec3(out.sample.V_WH.v, pose_.linear_velocity_m_s);
    wire::FromVec3(out.sample.V_WH.w, pose_.angular_velocity_rad_s);
    link_.up.Send(now_ns_, pose_);
  }
  void Serve() {
    while (!frozen_ && link_.up.next_arrival_ns() && *link_.up.next_arrival_ns() <= now_ns_) {
      served_ns_ = std::max(served_ns_, *link_.up.next_arrival_ns());
      const std::optional<wire::HapticPose> pose = link_.up.Receive(now_ns_);
      wire::Wrench answer{};
      if (!server_ || !server_->OnPose(*pose, answer)) continue;
      answer.step_time_s = 1e-5;  // the only field that a clock has touched
      if (forge) forge(answer);
      link_.down.Send(served_ns_, answer);
    }
    if (frozen_) served_ns_ = now_ns_;
  }
  void Deliver(std::int64_t until_ns) {
    while (const std::optional<wire::Wrench> wrench = link_.down.Receive(until_ns)) {
      core_.Take(ToReply(*wrench, until_ns));
    }
  }

  StillDevice device_;
  StationCore core_{device_};
  std::shared_ptr<const ServedTool> tool_ = BallTool();
  std::unique_ptr<ServoLoop> server_;
  SimulatedLink<wire::HapticPose, wire::Wrench> link_;
  wire::HapticPose pose_{};
  Wrench before_;
  bool frozen_ = false;
  std::int64_t now_ns_ = 1'000'000'000;
  std::int64_t served_ns_ = 0;
};

}  // namespace palpate::test
