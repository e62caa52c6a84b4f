#include "devices/forcedimension/forcedimension_device.h"

#include <limits>
#include <optional>
#include <utility>

#include "common/error.h"
#include "common/text/number_of.h"
#include "devices/forcedimension/dhd_frame.h"
#include "devices/wrench_limiter.h"

namespace palpate {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// The status is read a hundred times a second, so that a cut of the force by the arm is seen
/// before a user can restore it.
constexpr std::uint64_t kTicksPerStatus = 10;
/// Beyond the reach of any arm; a position further away is invalid.
constexpr double kFarthest_m = 1.0;

bool IsCalibrating(dhd::Condition condition) {
  return condition == dhd::Condition::kNotCalibrated ||
         condition == dhd::Condition::kWristNotCalibrated;
}

}  // namespace

// Opening.

ForceDimensionDevice::ForceDimensionDevice(const DeviceOptions& options)
    : options_(options),
      library_(dhd::LoadLibrary()),
      gate_(options_.rate_Hz),
      turn_rate_(options_.rate_Hz) {
  try {
    Open();
    ReadDataSheet();
    Configure();
  } catch (...) {
    Close();
    throw;
  }
}

ForceDimensionDevice::~ForceDimensionDevice() {
  Close();
}

void ForceDimensionDevice::Check(int answer, const char* what) const {
  if (answer >= 0) return;
  throw Error("forcedimension: " + std::string(what) + ": " +
              dhd::DescribeError(dhd_.dhdErrorGetLast()));
}

void ForceDimensionDevice::Open() {
  if (options_.arm.empty()) {
    id_ = dhd_.dhdOpen();
  } else {
    const std::string& text = options_.arm;
    const int serial = NumberOf<int>(text).value_or(-1);
    if (serial < 0) {
      throw UsageError("--device-name '" + text +
                       "': give the arm's serial number, as on its label: digits only");
    }
    id_ = dhd_.dhdOpenSerial(serial);
  }
  if (id_ >= 0) return;
  const int code = dhd_.dhdErrorGetLast();
  const int there = dhd_.dhdGetDeviceCount();
  throw Error("forcedimension: the arm" +
              (options_.arm.empty() ? "" : " with serial number " + options_.arm) +
              " cannot be opened (the library finds " + std::to_string(there < 0 ? 0 : there) +
              "): " + dhd::DescribeError(code));
}

void ForceDimensionDevice::ReadDataSheet() {
  const char id = static_cast<char>(id_);
  const int type = dhd_.dhdGetSystemType(id);
  Check(type, "dhdGetSystemType");
  const char* name = dhd_.dhdGetSystemName(id);
  unsigned short serial = 0;
  Check(dhd_.dhdGetSerialNumber(&serial, id), "dhdGetSerialNumber");
  int major = 0, minor = 0, release = 0, revision = 0;
  dhd_.dhdGetSDKVersion(&major, &minor, &release, &revision);
  info_ = ForceDimensionSheet(type);
  info_.model = std::string(name ? name : "unknown arm") + " (serial " + std::to_string(serial) +
                ", DHD " + std::to_string(major) + "." + std::to_string(minor) + "." +
                std::to_string(release) + ")";
  info_.rate_Hz = options_.rate_Hz;
  has_wrist_ = dhd_.dhdHasWrist(id);
  if (!dhd_.dhdHasActiveWrist(id) || info_.max_torque_Nm == 0.0) info_.torque_axes = 0;
}

void ForceDimensionDevice::Configure() {
  const char id = static_cast<char>(id_);
  if (options_.calibrate) Check(dhd_.dhdReset(id), "dhdReset");
  // For the weight of the original handle, which the library knows.
  Check(dhd_.dhdSetGravityCompensation(dhd::kOn, id), "dhdSetGravityCompensation");
  if (dhd_.dhdHasActiveGripper(id) && dhd_.dhdEmulateButton(dhd::kOn, id) < 0) {
    notes_ = "the gripper cannot replace a button (" + dhd::DescribeError(dhd_.dhdErrorGetLast()) +
             "); forces need --enable-forces";
  }
  Tell(Wrench{});
  if (state_.errors > 0) {
    throw Error("forcedimension: setting no force: " + dhd::DescribeError(state_.error));
  }
  // A sigma's forces are off until they are enabled; for other arms this does no harm.  An arm that
  // is not calibrated refuses, and this is repeated once it is calibrated.
  LookAtStatus();
  enable_when_calibrated_ = IsCalibrating(state_.condition);
  if (!enable_when_calibrated_) {
    Check(dhd_.dhdEnableForce(dhd::kOn, id), "dhdEnableForce");
    LookAtStatus();
  }
  if (state_.errors > 0) {
    throw Error("forcedimension: dhdGetStatus: " + dhd::DescribeError(state_.error));
  }
  states_.Write(state_);
}

void ForceDimensionDevice::Close() noexcept {
  if (id_ < 0) return;
  const char id = static_cast<char>(id_);
  Tell(Wrench{});
  dhd_.dhdEnableForce(dhd::kOff, id);
  dhd_.dhdStop(id);
  dhd_.dhdClose(id);
  id_ = -1;
}

// The station's loop: no allocation, lock, log or exception of ours.

bool ForceDimensionDevice::Took(int answer) noexcept {
  if (answer >= 0) return true;  // includes DHD_TIMEGUARD and DHD_MOTOR_SATURATED
  state_.error = dhd_.dhdErrorGetLast();
  ++state_.errors;
  gate_.Fault();
  // A failure without a code counts as an unknown error.
  if (dhd::ClassOf(state_.error) != dhd::ErrorClass::kPause) state_.latched = true;
  return false;
}

bool ForceDimensionDevice::ReadPose() noexcept {
  const char id = static_cast<char>(id_);
  // A getter that fails does not change its arguments, so initialise them with no valid pose.
  Vec3 p(kNaN, kNaN, kNaN), v(kNaN, kNaN, kNaN);
  double rows[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  if (has_wrist_) {
    rows[0][0] = kNaN;
    if (!Took(dhd_.dhdGetPositionAndOrientationFrame(&p.x(), &p.y(), &p.z(), rows, id))) {
      return false;
    }
  } else if (!Took(dhd_.dhdGetPosition(&p.x(), &p.y(), &p.z(), id))) {
    return false;
  }
  if (!Took(dhd_.dhdGetLinearVelocity(&v.x(), &v.y(), &v.z(), id))) return false;
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const std::optional<Mat3> R = NearestRotation(dhd::ToW(Mat3(Eigen::Map<RowMajor>(rows[0]))));
  if (!R || !(p.norm() < kFarthest_m) || !v.allFinite()) {
    ++state_.bad_poses;
    gate_.Fault();
    return false;
  }
  sample_.X_WH = {dhd::ToW(p), Quat(*R)};
  sample_.V_WH = {dhd::ToW(v), turn_rate_.Of(sample_.X_WH.q)};
  return true;
}

void ForceDimensionDevice::LookAtStatus() noexcept {
  const char id = static_cast<char>(id_);
  int status[dhd::kStatusRoom] = {};
  if (!Took(dhd_.dhdGetStatus(status, id))) return;
  state_.condition = dhd::ConditionOf(status);
  if (enable_when_calibrated_ && !IsCalibrating(state_.condition)) {
    enable_when_calibrated_ = false;
    Took(dhd_.dhdEnableForce(dhd::kOn, id));
  }
  condition_.store(state_.condition, std::memory_order_relaxed);
}

DeviceSample ForceDimensionDevice::Read() noexcept {
  if (state_.ticks % kTicksPerStatus == 0) LookAtStatus();
  if (!ReadPose()) {
    sample_.V_WH = Twist{};
    turn_rate_.Restart();
  }
  sample_.buttons = dhd_.dhdGetButtonMask(static_cast<char>(id_));
  if (state_.condition != dhd::Condition::kReady || state_.latched) gate_.Fault();
  sample_.status =
      gate_.open()
          ? kDeviceOk
          : kDeviceFault | (IsCalibrating(state_.condition) ? kDeviceCalibrating : kDeviceOk);
  return sample_;
}

void ForceDimensionDevice::Tell(const Wrench& wrench) noexcept {
  const char id = static_cast<char>(id_);
  const Vec3 f = dhd::ToD(wrench.force), t = dhd::ToD(wrench.torque);
  state_.rendered = wrench;
  if (info_.torque_axes == 0) {
    state_.rendered.torque.setZero();
    Took(dhd_.dhdSetForce(f.x(), f.y(), f.z(), id));
  } else {
    Took(dhd_.dhdSetForceAndTorque(f.x(), f.y(), f.z(), t.x(), t.y(), t.z(), id));
  }
}

void ForceDimensionDevice::Apply(const LimitedWrench& wrench) noexcept {
  Tell(gate_.Passes(wrench.wrench()) ? wrench.wrench() : Wrench{});
  ++state_.ticks;
  latched_.store(state_.latched, std::memory_order_relaxed);
  states_.Write(state_);
}

// The station's main thread.

const ForceDimensionState& ForceDimensionDevice::State() {
  states_.Read(seen_);
  return seen_;
}

DeviceNews ForceDimensionDevice::Attend() {
  DeviceNews news{.faults = {}, .notes = std::exchange(notes_, {})};
  const ForceDimensionState& state = State();
  // An error in every tick is reported once a second.
  const bool another = state.error != error_told_ || state.ticks >= next_telling_ticks_;
  if (state.errors > errors_told_ && another) {
    const std::uint64_t times = state.errors - errors_told_;
    AddLine(news.faults, "the arm reports " + dhd::DescribeError(state.error) +
                             (times > 1 ? " (" + std::to_string(times) + " errors)" : ""));
    errors_told_ = state.errors;
    error_told_ = state.error;
    next_telling_ticks_ = state.ticks + static_cast<std::uint64_t>(info_.rate_Hz);
    if (state.latched) {
      AddLine(news.faults, "the arm's forces are off until the station is started again");
    }
  }
  if (!told_any_ || state.condition != condition_told_) {
    if (state.condition == dhd::Condition::kReady) {
      AddLine(news.notes, "the arm is ready: forces come in by a ramp");
    } else {
      AddLine(news.faults, dhd::DescribeCondition(state.condition));
    }
    condition_told_ = state.condition;
    told_any_ = true;
  }
  return news;
}

const char* ForceDimensionDevice::activity() const noexcept {
  if (latched_.load(std::memory_order_relaxed)) return "arm at fault";
  return dhd::TextOf(condition_.load(std::memory_order_relaxed)).name;
}

DeviceKind ForceDimensionKind() {
  return {.name = "forcedimension",
          .what = "omega, delta, sigma or lambda; --device-name SERIAL",
          .max_rate_Hz = 4000.0,
          .check_host = [](const std::string&) { dhd::LoadLibrary(); },
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            return std::make_unique<ForceDimensionDevice>(options);
          }};
}

}  // namespace palpate
