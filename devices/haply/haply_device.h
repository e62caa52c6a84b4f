#pragma once

#include <atomic>
#include <string>

#include "devices/arm_parts.h"
#include "devices/device_factory.h"
#include "devices/haply/inverse_client.h"

namespace palpate {

/// Haply's Inverse3, Inverse3x or Minverse, through the Inverse Service; a VerseGrip, if present,
/// gives orientation and buttons.  Three axes of force, no torque.  W has x to the right, y up and
/// z towards the user; its origin is the centre of the reach.
/// Thread contract: as Device; a thread of its own communicates with the service (InverseClient).
class HaplyDevice final : public Device {
 public:
  /// Number of ticks without a reply after which the device counts as faulty and gets no force: 10
  /// ms at 1 kHz.
  static constexpr int kStaleTicks = 10;

  /// Throws Error, with the remedy, if there is no service or no device.
  explicit HaplyDevice(const DeviceOptions& options);

  const DeviceInfo& info() const override { return info_; }
  DeviceSample Read() noexcept override;
  void Apply(const LimitedWrench& wrench) noexcept override;
  DeviceNews Attend() override;
  const char* activity() const noexcept override;

  /// The state at the newest tick.  Call it from the loop's thread.
  const haply::ServiceState& service() const noexcept { return state_; }
  const Vec3& sent_force() const noexcept { return sent_; }

 private:
  enum class Condition { kReady, kNoService, kStalled, kLies, kNotCalibrated };

  DeviceInfo info_;
  Vec3 centre_ = Vec3::Zero();
  // Used by the loop.
  haply::ServiceState state_;
  DeviceSample sample_;
  ReturnGate gate_;
  TurnRate turn_rate_;
  Vec3 sent_ = Vec3::Zero();
  int silent_ticks_ = 0;

  std::atomic<Condition> condition_{Condition::kStalled};
  // Used by the main thread.
  Condition reported_ = Condition::kStalled;
  bool told_grip_ = false;
  haply::InverseClient client_;
};

}  // namespace palpate
