#include "devices/haply/haply_device.h"

#include "devices/wrench_limiter.h"

namespace palpate {
namespace {

// No data sheet was available.  [I] 2 N is the default limit of Isaac Lab's driver for the
// Inverse3, used as the continuous force; [E] the peak is twice that, and a Minverse has half of
// both.  Raise them only with the sheet of your device.
constexpr double kContinuous_N = 2.0;
constexpr double kPeak_N = 4.0;
constexpr double kSmaller = 0.5;
/// [D] The maker's tutorial for position control stays within these radii of the centre of
/// the reach.
constexpr double kReach_m = 0.10;
constexpr double kMinverseReach_m = 0.04;
/// [E] Resolution of the encoders at the cursor.
constexpr double kResolution_m = 0.1e-3;
constexpr double kResolution_rad = 2e-3;
/// [D] The cursor's position in the maker's example of a first message, in W: about the centre of
/// the reach if no preset puts the origin there.
const Vec3 kCentre_m(0.0, 0.15, 0.12);
/// Greatest motion between two replies.  No hand moves so far in a millisecond, but a device that
/// is being calibrated may.
constexpr double kJump_m = 0.05;

}  // namespace

HaplyDevice::HaplyDevice(const DeviceOptions& options)
    : gate_(options.rate_Hz),
      turn_rate_(options.rate_Hz),
      client_(haply::ServiceAddress(), options.arm, options.realtime) {
  const haply::Inventory& inventory = client_.inventory();
  const bool small = inventory.type == "minverse";
  info_.model = "Haply " + inventory.type + " (" + inventory.device_id + ")";
  info_.max_force_N = kPeak_N * (small ? kSmaller : 1.0);
  info_.continuous_force_N = kContinuous_N * (small ? kSmaller : 1.0);
  info_.torque_axes = 0;
  info_.workspace_m = Vec3::Constant(2.0 * (small ? kMinverseReach_m : kReach_m));
  info_.position_resolution_m = kResolution_m;
  info_.rotation_resolution_rad = kResolution_rad;
  info_.rate_Hz = options.rate_Hz;
  if (!inventory.centred) centre_ = kCentre_m;
}

DeviceSample HaplyDevice::Read() noexcept {
  const Vec3 before = sample_.X_WH.p;
  const bool first = state_.replies == 0;
  silent_ticks_ = client_.Read(state_) ? 0 : silent_ticks_ + 1;
  Condition condition = Condition::kReady;
  if (state_.replies > 0 && !state_.up) {
    condition = Condition::kNoService;
  } else if (state_.replies == 0 || silent_ticks_ > kStaleTicks) {
    condition = Condition::kStalled;
  } else if (state_.lie != haply::Lie::kNone) {
    condition = Condition::kLies;
  } else if (!state_.reading.calibrated) {
    condition = Condition::kNotCalibrated;
  }
  condition_.store(condition, std::memory_order_relaxed);
  if (condition != Condition::kReady) {
    // Keeps the pose, and clears the buttons.
    gate_.Fault();
    sample_.V_WH = Twist{};
    turn_rate_.Restart();
    sample_.buttons = 0;
  } else {
    sample_.X_WH = {state_.reading.p - centre_, state_.reading.q};
    sample_.V_WH = {state_.reading.v, turn_rate_.Of(state_.reading.q)};
    sample_.buttons = state_.reading.buttons;
    if (!first && (sample_.X_WH.p - before).norm() > kJump_m) gate_.Fault();
  }
  sample_.status = gate_.open()                             ? kDeviceOk
                   : condition == Condition::kNotCalibrated ? kDeviceFault | kDeviceCalibrating
                                                            : kDeviceFault;
  return sample_;
}

void HaplyDevice::Apply(const LimitedWrench& wrench) noexcept {
  sent_ = gate_.Passes(wrench.wrench()) ? wrench.wrench().force : Vec3::Zero().eval();
  client_.Send(sent_);
}

DeviceNews HaplyDevice::Attend() {
  DeviceNews news = client_.TakeNews();
  if (!told_grip_ && client_.inventory().grip_id.empty()) {
    AddLine(news.notes, "no VerseGrip: the tool does not turn, and forces need --enable-forces");
  }
  told_grip_ = true;
  const Condition condition = condition_.load(std::memory_order_relaxed);
  if (condition != reported_) {
    if (condition == Condition::kStalled) {
      AddLine(news.faults,
              "the Inverse Service does not answer in time: no force; end what loads the machine, "
              "or start the service again ('sudo systemctl restart haply-inverse-service')");
    } else if (condition == Condition::kNotCalibrated) {
      AddLine(news.faults,
              "forces are off; to calibrate the device: put the grip on its inkwell and wait until "
              "the light is steady");
    } else if (condition == Condition::kReady) {
      AddLine(news.notes, "the device is ready: forces come in by a ramp");
    }
    reported_ = condition;
  }
  return news;
}

const char* HaplyDevice::activity() const noexcept {
  switch (condition_.load(std::memory_order_relaxed)) {
    case Condition::kNoService:
      return "service gone";
    case Condition::kStalled:
      return "service silent";
    case Condition::kLies:
      return "service at fault";
    case Condition::kNotCalibrated:
      return "to be calibrated";
    case Condition::kReady:
      return "";
  }
  return "";
}

DeviceKind HaplyKind() {
  return {.name = "haply",
          .what = "Haply Inverse3 with VerseGrip; --device-name ID",
          .max_rate_Hz = 2000.0,
          .check_host = [](const std::string&) { haply::CheckService(haply::ServiceAddress()); },
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            return std::make_unique<HaplyDevice>(options);
          }};
}

}  // namespace palpate
