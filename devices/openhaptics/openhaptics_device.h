#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "common/realtime/latest_mailbox.h"
#include "devices/arm_parts.h"
#include "devices/device_factory.h"
#include "devices/openhaptics/hd_library.h"
#include "devices/openhaptics/output_gate.h"

namespace palpate {

/// The state after the latest tick.
struct OpenHapticsState {
  std::uint64_t ticks = 0;
  OutputGate::State output = OutputGate::State::kCalibrating;
  Wrench rendered;  ///< the wrench commanded to the arm; torque only if it has motors for it
  std::uint32_t buttons = 0;
  std::uint32_t presses = 0;     ///< number of button presses so far, any button
  std::uint64_t bad_poses = 0;   ///< invalid transforms; the previous pose was kept
  std::uint64_t long_ticks = 0;  ///< number of wrenches not set because their tick took too long
  // Read ten times a second, if the arm has them.
  std::array<double, 6> motor_temperature{};  ///< 0 to 1
  bool docked = false;                        ///< in its inkwell
  // Indexed by hd::ErrorClass.
  std::array<std::uint64_t, 5> errors{};
  std::array<hd::ErrorInfo, 5> cause{};  ///< the first error of the latest burst, which caused
                                         ///< the others
};

/// An arm that OpenHaptics drives: PHANTOM Premium, Omni, Desktop, Touch.  The library is loaded at
/// run time.  W is the arm's own frame: x to the right, y up, z towards the user.
///
/// The library's scheduler thread ticks.  Each tick is one frame: it reads the state, runs the
/// station's tick, which sets the wrench that it has just computed, and ends.  So no old force is
/// repeated: if there is no station's tick, or after an error, the frame sets nothing, which by the
/// library's rule is zero force.
/// Thread contract: as Device.  Read and Apply only from within a tick.
class OpenHapticsDevice final : public Device {
 public:
  /// A wrench that is ready later than this after the start of its tick is not set.
  static constexpr double kLongestTick_s = 0.010;

  /// Opens the arm with its motors off and begins its calibration, which Attend continues. Throws
  /// Error, with the remedy, if any of this fails.
  explicit OpenHapticsDevice(const DeviceOptions& options);
  ~OpenHapticsDevice() override;
  OpenHapticsDevice(const OpenHapticsDevice&) = delete;
  OpenHapticsDevice& operator=(const OpenHapticsDevice&) = delete;

  const DeviceInfo& info() const override { return info_; }
  DeviceSample Read() noexcept override { return sample_; }
  void Apply(const LimitedWrench& wrench) noexcept override;
  bool StartTicks(std::function<void()> tick) override;
  void StopTicks() override;
  DeviceNews Attend() override;
  const char* activity() const noexcept override;

  /// Returns the state after the latest tick.  Call it from the thread that calls Attend.
  const OpenHapticsState& State();

 private:
  static constexpr hd::Handle kNone = hd::kInvalidHandle;

  // The steps of opening, in this order.
  void Init(const std::string& name);
  void ReadDataSheet();
  void Configure();
  void Start();
  void Close() noexcept;
  int Integer(hd::Enum what, const char* name);
  double Positive(hd::Enum what, const char* name, double largest);
  std::string Text(hd::Enum what);
  /// Throws Error if the library reports an error.
  void Check(const std::string& what);
  void DiscardErrors() noexcept;

  // Called by the scheduler's thread.
  void OnTick() noexcept;
  void ReadFrame() noexcept;
  void ReadNowAndThen() noexcept;
  void SwitchMotors() noexcept;
  void Note(const hd::ErrorInfo& error) noexcept;
  void DrainErrors() noexcept;
  template <class Get>
  void Ask(bool& has, Get get) noexcept;

  // Called by the station's main thread.
  template <class Call>
  void InScheduler(Call call);
  bool SchedulerLives() const noexcept;
  std::string Calibrate();
  std::string NewErrors();

  DeviceOptions options_;
  hd::Library library_;
  const hd::Functions& hd_{library_.functions};
  hd::Handle handle_ = kNone;
  hd::SchedulerHandle callback_ = 0;
  bool scheduled_ = false;
  bool running_ = false;
  int output_dof_ = 0;  // number of axes that it can drive: 3 (force) or 6
  hd::Enum calibration_style_ = 0;
  DeviceInfo info_;
  std::string notes_;  // news from opening, for the first Attend

  std::function<void()> tick_;
  std::atomic<bool> serving_{false};  // tick_ is set
  std::atomic<std::int64_t> last_tick_ns_{0};
  std::atomic<OutputGate::State> output_{OutputGate::State::kCalibrating};
  LatestMailbox<OpenHapticsState> states_;

  // Used by the scheduler's thread while it runs.
  OutputGate gate_{1000.0};
  TurnRate turn_rate_{1000.0};
  OpenHapticsState state_;
  DeviceSample sample_;
  std::array<std::uint64_t, 5> last_error_ticks_{};
  bool in_frame_ = false;
  bool motors_on_ = false;
  std::uint64_t slow_period_ = 100;  // ticks between two ReadNowAndThen
  bool has_temperature_ = true;
  bool has_inkwell_ = true;

  // Used by the main thread.
  OpenHapticsState seen_;
  std::uint64_t next_look_ticks_ = 0;
  hd::Enum calibration_asked_ = 0;  // the calibration that the user was told to do
  bool calibrated_ = false;
  std::uint32_t presses_used_ = 0;
  std::array<std::uint64_t, 5> errors_told_{};
  std::array<std::uint64_t, 5> told_at_ticks_{};
  OutputGate::State output_told_ = OutputGate::State::kCalibrating;
};

}  // namespace palpate
