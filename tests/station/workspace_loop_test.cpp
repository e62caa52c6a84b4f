// A device in a workspace, driven by the station's core: clutch and walls go the way of all force.
#include <algorithm>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "client/station/station_core.h"
#include "devices/workspace.h"
#include "tests/station/still_device.h"

namespace palpate {
namespace {

constexpr std::int64_t kMs = 1'000'000;

class WorkspaceLoop : public testing::Test {
 protected:
  WorkspaceLoop() {
    Workspace workspace;
    workspace.clutch_button = 0;
    workspace.wall_force_N = 3.0;
    auto inside = std::make_unique<Arm>();
    arm_ = inside.get();
    device_ = std::make_unique<WorkspaceDevice>(std::move(inside), workspace);
    core_ = std::make_unique<StationCore>(*device_);
  }
  struct Arm final : Device {
    Arm() {
      data.max_force_N = data.continuous_force_N = 22.0;
      data.max_torque_Nm = data.continuous_torque_Nm = 0.5;
      data.workspace_m = Vec3(0.4, 0.4, 0.4);
    }
    const DeviceInfo& info() const override { return data; }
    DeviceSample Read() noexcept override { return still.sample; }
    void Apply(const LimitedWrench& wrench) noexcept override { still.Apply(wrench); }
    DeviceInfo data;
    test::StillDevice still;
  };

  void Tick(const Wrench& scene) {
    now_ += kMs;
    const OutgoingPose pose = core_->Sense(now_, true);
    Reply reply;
    reply.pose_sequence = pose.sequence;
    reply.pose_time_ns = pose.sample_time_ns;
    reply.received_ns = pose.sample_time_ns + kMs / 20;
    reply.wrench = scene;
    core_->Take(reply);
    core_->Act(now_);
    const Vec3 force = arm_->still.applied.force;
    largest_step_ = std::max(largest_step_, (force - force_).norm());
    force_ = force;
  }

  Arm* arm_;
  std::unique_ptr<WorkspaceDevice> device_;
  std::unique_ptr<StationCore> core_;
  std::int64_t now_ = 1'000'000 * kMs;
  Vec3 force_ = Vec3::Zero();
  double largest_step_ = 0.0;
};

TEST_F(WorkspaceLoop, HasNoWallsUntilForcesAreEnabledAndRampsThemIn) {
  arm_->still.sample.X_WH.p.x() = 0.2;  // the end of its reach
  for (int i = 0; i < 500; ++i) Tick({});
  EXPECT_EQ(force_, Vec3::Zero());
  core_->EnableForces(true);
  for (int i = 0; i < 500; ++i) Tick({});
  EXPECT_NEAR(force_.x(), -3.0, 1e-9);
  EXPECT_LE(largest_step_, 22.0 / 5.0);  // the limiter's slew
  EXPECT_LE(largest_step_, 3.0 / 200.0 + 1e-9);
}

TEST_F(WorkspaceLoop, BoundsWallsAndContactTogether) {
  core_->EnableForces(true);
  arm_->still.sample.X_WH.p.x() = 0.2;
  for (int i = 0; i < 1000; ++i) Tick({Vec3(-100, 0, 0), Vec3::Zero()});
  EXPECT_NEAR(force_.norm(), 22.0, 1e-9);
}

}  // namespace
}  // namespace palpate
