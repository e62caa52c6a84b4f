#include "devices/spacemouse/space_mouse_device.h"

#include <algorithm>
#include <cmath>

#include "devices/device_factory.h"

namespace palpate {

double RateControl::Share(double counts) noexcept {
  const double beyond = std::max(0.0, std::abs(counts) - kDeadBand);
  const double share = std::min(1.0, beyond / (kFullDeflection - kDeadBand));
  return std::copysign(share * share, counts);
}

Twist RateControl::Velocity(const std::array<int, 6>& axes) noexcept {
  // libspnav negates z in the same way, also for rotations (spnav_posrot_moveobj).
  return {kTopSpeed_m_s * Vec3(Share(axes[0]), Share(axes[1]), -Share(axes[2])),
          kTopTurn_rad_s * Vec3(Share(axes[3]), Share(axes[4]), -Share(axes[5]))};
}

SpaceMouseDevice::SpaceMouseDevice(const Pose& start)
    : BlindDevice("SpaceMouse (", 20.0, start) {  // a SpaceMouse has no workspace limits
  info_.model += reader_.device_name() + ")";
}

DeviceSample SpaceMouseDevice::Read() noexcept {
  if (reader_.Read(state_)) state_age_s_ = 0.0;
  const bool live = state_.link == SpacenavState::Link::kUp && state_age_s_ < kPushLives_s;
  Twist V = live ? RateControl::Velocity(state_.axes) : Twist{};
  for (int i = 0; i < 3; ++i) {
    const double p = hand_.pose().p[i];
    if (std::abs(p) >= 0.5 * info_.workspace_m[i] && p * V.v[i] > 0.0) V.v[i] = 0.0;
  }
  pushed_ = !V.v.isZero(0.0) || !V.w.isZero(0.0);
  hand_.Drive(V);
  return {
      hand_.pose(), hand_.twist(), state_.buttons,
      kDeviceForcesIgnored | (state_.link == SpacenavState::Link::kUp ? kDeviceOk : kDeviceFault)};
}

void SpaceMouseDevice::Apply(const LimitedWrench& wrench) noexcept {
  BlindDevice::Apply(wrench);
  state_age_s_ += kTick_s;
}

const char* SpaceMouseDevice::activity() const noexcept {
  switch (state_.link) {
    case SpacenavState::Link::kNoDaemon:
      return "stopped: spacenavd has ended";
    case SpacenavState::Link::kNoDevice:
      return "stopped: the SpaceMouse is unplugged";
    case SpacenavState::Link::kUp:
      break;
  }
  if (!pushed_) return "rests";
  return hand_.held_back() ? "moves, as far as it may press" : "moves";
}

DeviceKind SpaceMouseKind() {
  return {.name = "spacemouse",
          .what = "a SpaceMouse: its deflection sets the tool's speed; no force",
          .check_host = [](const std::string&) { FindSpacenavd(); },
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            return std::make_unique<SpaceMouseDevice>(options.start);
          }};
}

}  // namespace palpate
