#include "devices/openhaptics/openhaptics_device.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <thread>
#include <utility>

#include <pthread.h>

#include "common/error.h"
#include "common/realtime/steady_clock.h"
#include "devices/openhaptics/device_nodes.h"
#include "devices/wrench_limiter.h"

namespace palpate {
namespace {

constexpr double kMetresPerMm = 1e-3;
constexpr double kMilli = 1e3;  // mN m in one N m
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// More than the library's queue holds; ensures that a library that repeats an error for ever does
/// not hang a tick.
constexpr int kMostErrorsPerDrain = 64;
/// A scheduler that has not ticked for this long counts as dead; waiting for it could last
/// for ever.
constexpr std::int64_t kDead_ns = 1'000'000'000;
/// Above the force of the strongest arm (Premium 1.5 High Force: 37.5 N); a larger figure is in
/// another unit.
constexpr double kMostForce_N = 50.0;
constexpr double kMostTorque_mNm = 2000.0;
/// The library does not report an arm's encoder resolution, which the limiter's energy stage needs.
/// These are the values of the coarsest arm, the Touch: 450 dpi by its data sheet; its gimbal has
/// potentiometers, [estimate] ten bits per turn, while driven gimbals have encoders.
constexpr double kResolution_m = 0.055e-3;
constexpr double kResolution_rad = 6e-3;
constexpr double kDrivenResolution_rad = 1.4e-4;  // Premium 6DOF, roll: 0.0080 degrees
/// The scheduler's rate if it refuses another.
constexpr double kDefaultRate_Hz = 1000.0;
constexpr std::uint16_t kLast = 0;  // priority: after the tick's frame

std::size_t Index(hd::ErrorClass error_class) {
  return static_cast<std::size_t>(error_class);
}

std::string StyleName(hd::Enum style) {
  if (style == hd::kAuto) return "automatic";
  if (style == hd::kInkwell) return "inkwell";
  if (style == hd::kEncoderReset) return "encoder reset";
  return "no known style";
}

/// Chooses the calibration style that demands least of the user; an arm may support several.
hd::Enum EasiestStyle(hd::Enum styles) {
  for (const hd::Enum style : {hd::kAuto, hd::kInkwell, hd::kEncoderReset}) {
    if (styles & style) return style;
  }
  return 0;
}

std::string WhatToDo(hd::Enum style) {
  if (style == hd::kAuto) return "move the stylus slowly through the whole workspace";
  if (style == hd::kInkwell) return "put the stylus into the inkwell";
  if (style == hd::kEncoderReset) {
    return "put the arm into its reset position (upright, its links at right angles) and press a "
           "button on it; if it has none, leave it there and start again with --calibrate";
  }
  return "it names no style that is known; calibrate it with its vendor's program";
}

}  // namespace

// Opening.  These calls are legal only while the library's scheduler is stopped, up to Start().

OpenHapticsDevice::OpenHapticsDevice(const DeviceOptions& options)
    : options_(options), library_(hd::LoadLibrary()) {
  try {
    Init(options_.arm);
    ReadDataSheet();
    Configure();
    Start();
  } catch (...) {
    Close();
    throw;
  }
}

OpenHapticsDevice::~OpenHapticsDevice() {
  Close();
}

void OpenHapticsDevice::DiscardErrors() noexcept {
  for (int i = 0; i < kMostErrorsPerDrain && hd_.hdGetError().code != hd::kSuccess; ++i) {
  }
}

void OpenHapticsDevice::Check(const std::string& what) {
  const hd::ErrorInfo error = hd_.hdGetError();
  if (error.code == hd::kSuccess) return;
  DiscardErrors();
  throw Error("openhaptics: " + what + ": " + hd::Describe(error));
}

void OpenHapticsDevice::Init(const std::string& name) {
  // If a name was given, no other arm may be used instead.
  const std::vector<const char*> names =
      name.empty() ? std::vector<const char*>{nullptr, "Default Device", "Default PHANToM"}
                   : std::vector<const char*>{name.c_str()};
  hd::ErrorInfo first{};
  std::string tried;
  for (const char* candidate : names) {
    DiscardErrors();
    const hd::Handle handle = hd_.hdInitDevice(candidate);
    const hd::ErrorInfo error = hd_.hdGetError();
    if (handle != kNone && error.code == hd::kSuccess) {
      handle_ = handle;
      hd_.hdMakeCurrentDevice(handle);
      return Check("making the arm current");
    }
    if (handle != kNone) hd_.hdDisableDevice(handle);
    // Another name cannot help if the licence or the arm itself is unavailable.
    const bool last_word =
        error.code == hd::kInvalidLicense || error.code == hd::kDeviceAlreadyInitiated;
    if (tried.empty() || last_word) first = error;
    if (!tried.empty()) tried += ", ";
    tried += candidate ? candidate : "the default one";
    if (last_word) break;
  }
  DiscardErrors();
  std::string why = first.code == hd::kSuccess
                        ? std::string("the library gives no handle and no reason")
                        : hd::Describe(first);
  if (first.code != hd::kInvalidLicense && first.code != hd::kDeviceAlreadyInitiated) {
    why += "; " + DescribeDeviceNodes() +
           "; --device-name must be as in the vendor's set-up program, which keeps one file for "
           "each arm (~/.3dsystems/config/NAME.config, or in GTDD_HOME)";
  }
  throw Error("openhaptics: the arm cannot be opened (tried " + tried + "): " + why);
}

int OpenHapticsDevice::Integer(hd::Enum what, const char* name) {
  int value = 0;
  hd_.hdGetIntegerv(what, &value);
  Check(name);
  return value;
}

double OpenHapticsDevice::Positive(hd::Enum what, const char* name, double largest) {
  double value = kNaN;
  hd_.hdGetDoublev(what, &value);
  Check(name);
  if (!(value > 0.0 && value <= largest)) {
    throw Error(
        "openhaptics: " + std::string(name) + " is " + std::to_string(value) +
        ", and should be above 0 and at most " + std::to_string(largest) +
        "; without it the force cannot be limited: install the driver that matches the arm");
  }
  return value;
}

std::string OpenHapticsDevice::Text(hd::Enum what) {
  const char* text = hd_.hdGetString(what);
  const bool failed = hd_.hdGetError().code != hd::kSuccess;
  DiscardErrors();
  return failed || !text ? "unknown" : text;
}

void OpenHapticsDevice::ReadDataSheet() {
  info_.model = Text(hd::kDeviceModelType) + " (serial " + Text(hd::kSerialNumber) + ", driver " +
                Text(hd::kDriverVersion) + ", HD " + Text(hd::kVersion) + ")";
  const int input_dof = Integer(hd::kInputDof, "HD_INPUT_DOF");
  output_dof_ = Integer(hd::kOutputDof, "HD_OUTPUT_DOF");
  if (input_dof != 3 && input_dof != 6) {
    throw Error("openhaptics: HD_INPUT_DOF is " + std::to_string(input_dof) +
                ", and should be 3 or 6; install the driver that matches the arm");
  }
  if (output_dof_ != 3 && output_dof_ != 6) {
    throw Error("openhaptics: HD_OUTPUT_DOF is " + std::to_string(output_dof_) +
                ", and should be 3 or 6; install the driver that matches the arm");
  }
  info_.max_force_N = Positive(hd::kNominalMaxForce, "HD_NOMINAL_MAX_FORCE [N]", kMostForce_N);
  info_.continuous_force_N =
      Positive(hd::kNominalMaxContinuousForce, "HD_NOMINAL_MAX_CONTINUOUS_FORCE [N]", kMostForce_N);
  if (output_dof_ == 6) {
    info_.max_torque_Nm =
        Positive(hd::kNominalMaxTorque, "HD_NOMINAL_MAX_TORQUE_FORCE [mN m]", kMostTorque_mNm) /
        kMilli;
    info_.continuous_torque_Nm =
        Positive(hd::kNominalMaxContinuousTorque, "HD_NOMINAL_MAX_TORQUE_CONTINUOUS_FORCE [mN m]",
                 kMostTorque_mNm) /
        kMilli;
  } else {
    info_.torque_axes = 0;
  }
  info_.position_resolution_m = kResolution_m;
  info_.rotation_resolution_rad = output_dof_ == 6 ? kDrivenResolution_rad : kResolution_rad;
  std::array<double, 6> box{};
  hd_.hdGetDoublev(hd::kMaxWorkspace, box.data());
  Check("HD_MAX_WORKSPACE");
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    info_.workspace_m[i] = kMetresPerMm * (box[axis + 3] - box[axis]);
    info_.workspace_centre_m[i] = 0.5 * kMetresPerMm * (box[axis + 3] + box[axis]);
  }
  calibration_style_ =
      EasiestStyle(static_cast<hd::Enum>(Integer(hd::kCalibrationStyle, "HD_CALIBRATION_STYLE")));
}

void OpenHapticsDevice::Configure() {
  hd_.hdDisable(hd::kForceOutput);
  Check("switching the motors off");
  // The library's own limits act after the limiter.  One frame per tick is its default, and what
  // this driver uses.
  constexpr std::array<std::pair<hd::Enum, const char*>, 6> kBounds{
      {{hd::kMaxForceClamping, "HD_MAX_FORCE_CLAMPING"},
       {hd::kForceRamping, "HD_FORCE_RAMPING"},
       {hd::kSoftwareForceLimit, "HD_SOFTWARE_FORCE_LIMIT"},
       {hd::kSoftwareVelocityLimit, "HD_SOFTWARE_VELOCITY_LIMIT"},
       {hd::kSoftwareForceImpulseLimit, "HD_SOFTWARE_FORCE_IMPULSE_LIMIT"},
       {hd::kOneFrameLimit, "HD_ONE_FRAME_LIMIT"}}};
  for (const auto& [what, name] : kBounds) {
    hd_.hdEnable(what);
    const hd::ErrorInfo error = hd_.hdGetError();
    if (error.code == hd::kSuccess) continue;
    DiscardErrors();
    if (hd::ClassOf(error.code) != hd::ErrorClass::kUse) {
      throw Error("openhaptics: " + std::string(name) + ": " + hd::Describe(error));
    }
    AddLine(notes_, std::string("the library does not take ") + name +
                        ": the station's limiter alone bounds what it would");
  }

  hd_.hdSetSchedulerRate(static_cast<unsigned long>(options_.rate_Hz));
  const hd::ErrorInfo error = hd_.hdGetError();
  DiscardErrors();
  if (error.code != hd::kSuccess && error.code != hd::kInvalidValue &&
      error.code != hd::kInvalidOperation && error.code != hd::kTimerError) {
    throw Error("openhaptics: hdSetSchedulerRate: " + hd::Describe(error));
  }
  // HD_UPDATE_RATE cannot be used: it is measured, and the scheduler does not run yet.
  info_.rate_Hz = error.code == hd::kSuccess ? options_.rate_Hz : kDefaultRate_Hz;
  if (info_.rate_Hz != options_.rate_Hz) {
    AddLine(notes_, "the arm does not take the rate asked for; it runs at 1000 Hz");
  }
  gate_ = OutputGate(info_.rate_Hz);
  turn_rate_ = TurnRate(info_.rate_Hz);
  slow_period_ = static_cast<std::uint64_t>(std::max(1.0, info_.rate_Hz / 10.0));
  sample_.status = kDeviceCalibrating | kDeviceFault;
}

void OpenHapticsDevice::Start() {
  callback_ = hd_.hdScheduleAsynchronous(
      [](void* device) -> hd::CallbackCode {
        static_cast<OpenHapticsDevice*>(device)->OnTick();
        return hd::kContinue;
      },
      this, hd::kDefaultPriority);
  Check("hdScheduleAsynchronous");
  scheduled_ = true;
  running_ = true;
  hd_.hdStartScheduler();
  Check("hdStartScheduler");

  // A synchronous call to a scheduler that does not run would never return.
  for (const std::int64_t begun = SteadyNanoseconds(); last_tick_ns_.load() == 0;) {
    if (SteadyNanoseconds() - begun > kDead_ns) {
      throw Error(
          "openhaptics: the library's scheduler was started but does not run; check the arm's "
          "cable and power, end other programs that use it, and test it with its vendor's "
          "diagnostic program");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  // The library chooses its thread's priority, which is often an ordinary one.
  std::exception_ptr refused;
  InScheduler([&]() noexcept {
    int policy = SCHED_OTHER;
    sched_param parameters{};
    pthread_getschedparam(pthread_self(), &policy, &parameters);
    if (policy != SCHED_OTHER || options_.realtime.mode == RealtimeMode::kOff) return;
    try {
      EnterRealtime(options_.realtime);
    } catch (...) {
      refused = std::current_exception();
    }
  });
  if (refused) std::rethrow_exception(refused);
}

void OpenHapticsDevice::Close() noexcept {
  StopTicks();
  if (handle_ == kNone) return;
  hd_.hdDisableDevice(handle_);
  handle_ = kNone;
  DiscardErrors();
}

// The scheduler's thread: no allocation, lock, log or exception.

void OpenHapticsDevice::OnTick() noexcept {
  hd_.hdBeginFrame(handle_);  // which also sets force and torque to zero
  in_frame_ = true;
  state_.rendered = Wrench{};
  ReadFrame();
  if (state_.ticks % slow_period_ == 0) ReadNowAndThen();
  DrainErrors();  // before anything is computed from data that the errors may have spoilt
  sample_.status = gate_.state() == OutputGate::State::kOn ? kDeviceOk
                   : gate_.state() == OutputGate::State::kCalibrating
                       ? kDeviceCalibrating | kDeviceFault
                       : kDeviceFault;
  if (serving_.load(std::memory_order_acquire)) tick_();
  in_frame_ = false;
  hd_.hdEndFrame(handle_);
  DrainErrors();
  SwitchMotors();

  ++state_.ticks;
  state_.output = gate_.state();
  output_.store(state_.output, std::memory_order_relaxed);
  last_tick_ns_.store(SteadyNanoseconds(), std::memory_order_relaxed);
  states_.Write(state_);
}

void OpenHapticsDevice::ReadFrame() noexcept {
  // A getter that fails does not change its argument, so initialise it with no valid pose.
  std::array<double, 16> transform;
  transform.fill(kNaN);
  std::array<double, 3> velocity{};
  int buttons = 0;
  hd_.hdGetDoublev(hd::kCurrentTransform, transform.data());
  hd_.hdGetDoublev(hd::kCurrentVelocity, velocity.data());
  hd_.hdGetIntegerv(hd::kCurrentButtons, &buttons);

  state_.presses += (static_cast<std::uint32_t>(buttons) & ~state_.buttons) != 0;
  state_.buttons = sample_.buttons = static_cast<std::uint32_t>(buttons);
  const Eigen::Map<const Eigen::Matrix4d> X(transform.data());  // column-major, as Eigen's own
  const Vec3 p = kMetresPerMm * X.topRightCorner<3, 1>();
  const Vec3 v = kMetresPerMm * Eigen::Map<const Vec3>(velocity.data());
  const std::optional<Mat3> R = NearestRotation(X.topLeftCorner<3, 3>());
  if (!R || !p.allFinite() || !v.allFinite()) {
    ++state_.bad_poses;
    sample_.V_WH = Twist{};
    gate_.Report(hd::ErrorClass::kForce);
    return;
  }
  const Quat q(*R);
  sample_.X_WH = {p, q};
  sample_.V_WH = {v, turn_rate_.Of(q)};
}

template <class Get>
void OpenHapticsDevice::Ask(bool& has, Get get) noexcept {
  if (!has) return;
  DrainErrors();
  get();
  // A value that this arm lacks is not queried again, and is no fault.
  for (int i = 0; i < kMostErrorsPerDrain; ++i) {
    const hd::ErrorInfo error = hd_.hdGetError();
    if (error.code == hd::kSuccess) return;
    if (hd::ClassOf(error.code) == hd::ErrorClass::kUse) {
      has = false;
    } else {
      Note(error);
    }
  }
}

void OpenHapticsDevice::ReadNowAndThen() noexcept {
  Ask(has_temperature_,
      [&] { hd_.hdGetDoublev(hd::kMotorTemperature, state_.motor_temperature.data()); });
  Ask(has_inkwell_, [&] {
    unsigned char out = 1;
    hd_.hdGetBooleanv(hd::kCurrentInkwellSwitch, &out);
    state_.docked = out == 0;
  });
  if (!has_inkwell_) state_.docked = false;
  if (!has_temperature_) return;
  double hottest = 0.0, known = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < output_dof_; ++i) {
    const double t = state_.motor_temperature[static_cast<std::size_t>(i)];
    // If one is unknown, the others do not show that it is cool; but they may show that they are
    // hot.  std::fmax passes over NaN.
    if (!(t <= hottest) && !std::isnan(hottest)) hottest = t;
    known = std::fmax(known, t);
  }
  gate_.SetTemperature(hottest);
  sample_.motor_temperature = known;  // corrects the limiter's model
}

void OpenHapticsDevice::Apply(const LimitedWrench& wrench) noexcept {
  if (!in_frame_) return;
  if (hd_.hdGetSchedulerTimeStamp() > kLongestTick_s) {
    ++state_.long_ticks;
    gate_.Report(hd::ErrorClass::kForce);
  }
  if (!gate_.Passes(wrench.wrench())) return;
  state_.rendered.force = wrench.wrench().force;
  hd_.hdSetDoublev(hd::kCurrentForce, state_.rendered.force.data());
  if (output_dof_ < 6) return;
  state_.rendered.torque = wrench.wrench().torque;
  const Vec3 torque_mNm = kMilli * state_.rendered.torque;
  hd_.hdSetDoublev(hd::kCurrentTorque, torque_mNm.data());
}

void OpenHapticsDevice::SwitchMotors() noexcept {
  if (gate_.motors_on() == motors_on_) return;
  motors_on_ = gate_.motors_on();
  if (motors_on_) {
    hd_.hdEnable(hd::kForceOutput);
  } else {
    hd_.hdDisable(hd::kForceOutput);
  }
  DrainErrors();
}

void OpenHapticsDevice::Note(const hd::ErrorInfo& error) noexcept {
  const hd::ErrorClass error_class = hd::ClassOf(error.code);
  gate_.Report(error_class);
  const std::size_t i = Index(error_class);
  if (state_.errors[i] == 0 || state_.ticks > last_error_ticks_[i] + slow_period_) {
    state_.cause[i] = error;
  }
  last_error_ticks_[i] = state_.ticks;
  ++state_.errors[i];
}

void OpenHapticsDevice::DrainErrors() noexcept {
  for (int i = 0; i < kMostErrorsPerDrain; ++i) {
    const hd::ErrorInfo error = hd_.hdGetError();
    if (error.code == hd::kSuccess) return;
    Note(error);
  }
}

// The station's threads.

template <class Call>
void OpenHapticsDevice::InScheduler(Call call) {
  hd_.hdScheduleSynchronous(
      [](void* data) -> hd::CallbackCode {
        (*static_cast<Call*>(data))();
        return hd::kDone;
      },
      &call, kLast);
}

bool OpenHapticsDevice::SchedulerLives() const noexcept {
  return running_ && SteadyNanoseconds() - last_tick_ns_.load(std::memory_order_relaxed) < kDead_ns;
}

bool OpenHapticsDevice::StartTicks(std::function<void()> tick) {
  tick_ = std::move(tick);
  serving_.store(true, std::memory_order_release);
  return true;
}

void OpenHapticsDevice::StopTicks() {
  serving_.store(false);  // from the next frame on no force is set, which means zero
  if (running_) {
    // Only while the scheduler ticks; otherwise this call would wait for ever.
    if (SchedulerLives() && output_.load() != OutputGate::State::kLatched) {
      InScheduler([this]() noexcept {
        motors_on_ = false;
        hd_.hdDisable(hd::kForceOutput);
        DrainErrors();
      });
    }
    hd_.hdStopScheduler();
    running_ = false;
    hd_.hdDisable(hd::kForceOutput);  // again, because the scheduler may not have run the call
  }
  if (scheduled_) hd_.hdUnschedule(callback_);
  scheduled_ = false;
  tick_ = nullptr;
  DiscardErrors();
}

const OpenHapticsState& OpenHapticsDevice::State() {
  states_.Read(seen_);
  return seen_;
}

DeviceNews OpenHapticsDevice::Attend() {
  DeviceNews news{.faults = {}, .notes = std::exchange(notes_, {})};
  const OpenHapticsState& state = State();
  AddLine(news.faults, NewErrors());
  if (state.output != output_told_) {
    if (state.output == OutputGate::State::kOn) {
      AddLine(news.notes, "the arm is ready: forces come in by a ramp");
    } else if (state.output == OutputGate::State::kCooling) {
      AddLine(news.faults, "the motors are hot: no force until they have cooled");
    } else if (state.output == OutputGate::State::kLatched) {
      AddLine(news.faults, "the arm's forces are off until the station is started again");
    }
    output_told_ = state.output;
  }
  // Ten times a second is plenty.
  if (!calibrated_ && state.output == OutputGate::State::kCalibrating && SchedulerLives() &&
      state.ticks >= next_look_ticks_) {
    next_look_ticks_ = state.ticks + slow_period_;
    AddLine(news.notes, Calibrate());
  }
  return news;
}

std::string OpenHapticsDevice::Calibrate() {
  const bool pressed = seen_.presses != presses_used_;
  presses_used_ = seen_.presses;
  const bool reset = calibration_style_ == hd::kEncoderReset;
  // Requested, and the arm is in position: for the reset position --calibrate asserts it; the
  // inkwell has a switch.
  const bool in_place = calibration_style_ != hd::kInkwell || seen_.docked;
  const bool forced = options_.calibrate && in_place;
  const hd::Enum style = calibration_style_;
  hd::Enum status = hd::kCalibrationNeedsManualInput;
  bool updated = false;
  InScheduler([&]() noexcept {
    hd_.hdMakeCurrentDevice(handle_);
    status = hd_.hdCheckCalibration();
    const bool asks =
        reset ? status != hd::kCalibrationOk && pressed : status == hd::kCalibrationNeedsUpdate;
    if (style != 0 && (forced || asks)) {
      hd_.hdUpdateCalibration(style);
      updated = true;
      status = hd_.hdCheckCalibration();
    }
    const auto failures = state_.errors;
    DrainErrors();
    if (state_.errors != failures) status = hd::kCalibrationNeedsManualInput;
    if (status == hd::kCalibrationOk && (updated || !options_.calibrate)) gate_.Open();
  });
  if (updated) options_.calibrate = false;
  if (status == hd::kCalibrationOk && !options_.calibrate) {
    calibrated_ = true;
    return updated ? "calibrated (" + StyleName(style) + ")" : "the arm is calibrated";
  }
  if (calibration_asked_ == status) return "";
  calibration_asked_ = status;
  return "forces are off; to calibrate the arm (" + StyleName(style) + "): " + WhatToDo(style);
}

std::string OpenHapticsDevice::NewErrors() {
  std::string lines;
  for (std::size_t i = 0; i < errors_told_.size(); ++i) {
    const std::uint64_t errors = seen_.errors[i];
    const std::uint64_t new_ones = errors - errors_told_[i];
    // An error in every tick is reported once a second.
    if (new_ones == 0 || (errors_told_[i] > 0 && seen_.ticks < told_at_ticks_[i])) continue;
    errors_told_[i] = errors;
    told_at_ticks_[i] = seen_.ticks + 10 * slow_period_;
    AddLine(lines, "the arm reports " + hd::Describe(seen_.cause[i]) +
                       (new_ones > 1 ? " (" + std::to_string(new_ones) + " times)" : ""));
  }
  return lines;
}

const char* OpenHapticsDevice::activity() const noexcept {
  switch (output_.load(std::memory_order_relaxed)) {
    case OutputGate::State::kCalibrating:
      return "calibrating";
    case OutputGate::State::kPaused:
      return "forces paused";
    case OutputGate::State::kCooling:
      return "motors cooling";
    case OutputGate::State::kLatched:
      return "arm at fault";
    case OutputGate::State::kOn:
      return "";
  }
  return "";
}

DeviceKind OpenHapticsKind() {
  return {.name = "openhaptics",
          .what = "a PHANTOM or Touch arm, through the OpenHaptics library",
          .max_rate_Hz = 4000.0,
          .check_host = [](const std::string&) { hd::LoadLibrary(); },
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            return std::make_unique<OpenHapticsDevice>(options);
          }};
}

}  // namespace palpate
