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

/// Returns the data sheet of a Force Dimension arm, by its dhdGetSystemType.  The driver fills in
/// model, rate and torque axes, for which it asks the library.  arm_sheets.cpp has the sources of
/// the figures. An unknown arm gets the lowest bounds of all.
DeviceInfo ForceDimensionSheet(int system_type);

/// The state after the latest tick.
struct ForceDimensionState {
  std::uint64_t ticks = 0;
  dhd::Condition condition = dhd::Condition::kForceOff;
  Wrench rendered;  ///< the wrench commanded to the arm, in W; torque only if it has motors for it
  int error = 0;    ///< the newest error code
  std::uint64_t errors = 0;
  std::uint64_t bad_poses = 0;  ///< invalid poses; the previous pose was kept
  bool latched = false;
};

/// A Force Dimension arm: omega, delta, sigma, lambda.  The library is loaded at run time.  W is
/// the arm's own frame, converted as dhd_frame.h says: x to the right, y up, z towards the user.
///
/// Read and Apply call the library in the station's loop, since the library has no thread that
/// ticks. The arm holds its last command until its own watchdog ends it, so each tick sends a
/// command, zero while the gate is closed.
/// Thread contract: as Device.
class ForceDimensionDevice final : public Device {
 public:
  /// Opens the arm with the serial number in the options, or the first arm, compensates its
  /// weight and enables its forces, with a zero command.  Throws Error, with the remedy, if any
  /// of this fails.
  explicit ForceDimensionDevice(const DeviceOptions& options);
  ~ForceDimensionDevice() override;
  ForceDimensionDevice(const ForceDimensionDevice&) = delete;
  ForceDimensionDevice& operator=(const ForceDimensionDevice&) = delete;

  const DeviceInfo& info() const override { return info_; }
  DeviceSample Read() noexcept override;
  void Apply(const LimitedWrench& wrench) noexcept override;
  DeviceNews Attend() override;
  const char* activity() const noexcept override;

  /// Returns the state after the latest tick.  Call it from the thread that calls Attend.
  const ForceDimensionState& State();

 private:
  void Open();
  void ReadDataSheet();
  void Configure();
  void Close() noexcept;
  /// Throws Error if the library returned a negative number.
  void Check(int answer, const char* what) const;

  // Called by the station's loop.
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

  // Used by the station's loop.
  DeviceSample sample_;
  ReturnGate gate_;
  TurnRate turn_rate_;
  ForceDimensionState state_;
  bool enable_when_calibrated_ = false;

  LatestMailbox<ForceDimensionState> states_;
  std::atomic<dhd::Condition> condition_{dhd::Condition::kForceOff};
  std::atomic<bool> latched_{false};

  // Used by the main thread.
  ForceDimensionState seen_;
  std::string notes_;  // news from opening, for the first Attend
  bool told_any_ = false;
  dhd::Condition condition_told_ = dhd::Condition::kReady;
  int error_told_ = 0;
  std::uint64_t errors_told_ = 0;
  std::uint64_t next_telling_ticks_ = 0;
};

}  // namespace palpate
