#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "common/realtime/latest_mailbox.h"
#include "devices/arm_parts.h"
#include "devices/device_factory.h"
#include "devices/forcedimension/dhd_library.h"
#include "devices/forcedimension/dhd_texts.h"

namespace palpate {

/// The data sheet of an arm of Force Dimension's, by dhdGetSystemType; model, rate and torque axes
/// are left to the driver, which asks the library.  Figures have their sources in arm_sheets.cpp.
/// An arm that is not known gets the weakest bounds there are.
DeviceInfo ForceDimensionSheet(int system_type);

/// What the latest tick saw and did.
struct ForceDimensionState {
  std::uint64_t ticks = 0;
  dhd::Condition condition = dhd::Condition::kForceOff;
  Wrench rendered;  ///< what the arm was told, in W; torque only where it has motors for that
  int error = 0;    ///< the newest
  std::uint64_t errors = 0;
  std::uint64_t bad_poses = 0;  ///< that were none; the pose before was held
  bool latched = false;
};

/// An arm of Force Dimension's: omega, delta, sigma, lambda.  The library is loaded at run time.
/// W is the arm's own frame as dhd_frame.h has it: x to the right, y up, z to the user.
///
/// Read and Apply each talk to the arm through the library, in the station's loop: the library has
/// no thread that ticks.  The arm keeps what it was told last until its own watchdog lets go, so
/// each tick tells it something, zero wherever the gate is closed.
/// Thread contract: as Device.
class ForceDimensionDevice final : public Device {
 public:
  /// Opens the arm that the options name by its serial number, or the first, compensates its weight
  /// and enables its forces, with none asked for.  Throws Error, with the remedy, where anything of
  /// it fails.
  explicit ForceDimensionDevice(const DeviceOptions& options);
  ~ForceDimensionDevice() override;
  ForceDimensionDevice(const ForceDimensionDevice&) = delete;
  ForceDimensionDevice& operator=(const ForceDimensionDevice&) = delete;

  const DeviceInfo& info() const override { return info_; }
  DeviceSample Read() noexcept override;
  void Apply(const LimitedWrench& wrench) noexcept override;
  std::string Attend() override;
  const char* activity() const noexcept override;

  /// Of the latest tick.  From the thread that calls Attend.
  const ForceDimensionState& State();

 private:
  void Open();
  void ReadDataSheet();
  void Configure();
  void Close() noexcept;
  /// Throws Error where the library's answer is negative.
  void Check(int answer, const char* what) const;

  // The station's loop.
  bool Took(int answer) noexcept;
  bool ReadPose() noexcept;
  void LookAtStatus() noexcept;
  void Tell(const Wrench& wrench) noexcept;

  const DeviceOptions options_;
  dhd::Library library_;
  const dhd::Functions& dhd_{library_.functions};
  int id_ = -1;
  bool has_wrist_ = false;
  DeviceInfo info_;

  // Of the loop.
  DeviceSample sample_;
  ReturnGate gate_;
  TurnRate turn_rate_;
  ForceDimensionState state_;
  bool enable_when_calibrated_ = false;

  LatestMailbox<ForceDimensionState> states_;
  std::atomic<dhd::Condition> condition_{dhd::Condition::kForceOff};
  std::atomic<bool> latched_{false};

  // Of the main thread.
  ForceDimensionState seen_;
  std::string notes_;  // from opening, for the first Attend
  bool told_any_ = false;
  dhd::Condition condition_told_ = dhd::Condition::kReady;
  int error_told_ = 0;
  std::uint64_t errors_told_ = 0;
  std::uint64_t next_telling_ticks_ = 0;
};

}  // namespace palpate
