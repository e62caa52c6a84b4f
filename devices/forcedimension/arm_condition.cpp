#include "devices/forcedimension/arm_condition.h"

#include <array>

namespace palpate::dhd {
namespace {

constexpr std::array<ConditionText, 17> kTexts{{
    {Condition::kReady, "", "nothing to do"},
    {Condition::kNoPower, "arm without power",
     "switch it on, check its power supply, and let its emergency stop out"},
    {Condition::kNotConnected, "arm not connected",
     "check the USB cable, and start the station again"},
    {Condition::kNotStarted, "arm not started",
     "its controller does not run: switch the arm off and on, and start the station again"},
    {Condition::kError, "arm at fault",
     "switch it off and on; if it comes again, check it with its vendor's HapticDesk"},
    {Condition::kNotCalibrated, "to be calibrated",
     "put the handle's calibration pole into the calibration pit (the rest position) and leave it "
     "there until the arm's light stops blinking"},
    {Condition::kWristNotCalibrated, "wrist to be calibrated",
     "turn the wrist gently to the end of each of its three axes, or run its vendor's HapticInit"},
    {Condition::kOffByButton, "forces off by the arm's button",
     "hold the handle and press the force button once more"},
    {Condition::kOffByVelocity, "forces off: moved too fast",
     "hold the handle, keep it still, and press the arm's force button; give the scene a softer "
     "coupling if it comes again"},
    {Condition::kOffByWatchdog, "forces off by the watchdog",
     "the arm heard nothing for too long: see why the station was held up (palpate-doctor), then "
     "press the arm's force button"},
    {Condition::kOffBySoftware, "forces off by a program",
     "forces were disabled by software: end other programs that use the arm, then press its force "
     "button or start the station again"},
    {Condition::kOffByUsb, "forces off: USB came loose",
     "check the USB cable (no hub), switch the arm off and on, and start the station again"},
    {Condition::kOffByDeadMan, "forces off: nobody holds the handle",
     "hold the handle, or the dead-man switch or pedal, and keep holding it"},
    {Condition::kOffUnknown, "forces off for an unknown reason",
     "press the arm's force button; please report it, with the library's version"},
    {Condition::kBrake, "arm braked", "the motors only brake: press the arm's force button"},
    {Condition::kIdle, "arm idle", "the motors are not driven: press the arm's force button"},
    {Condition::kForceOff, "forces off",
     "press the arm's force button or its pedal; a sigma has its forces off until then"},
}};

}  // namespace

std::span<const ConditionText> ConditionTexts() noexcept {
  return kTexts;
}

const ConditionText& TextOf(Condition condition) noexcept {
  return kTexts[static_cast<std::size_t>(condition)];
}

Condition ConditionOf(const int* status) noexcept {
  if (!status[kStatusPower]) return Condition::kNoPower;
  if (!status[kStatusConnected]) return Condition::kNotConnected;
  if (!status[kStatusStarted]) return Condition::kNotStarted;
  if (status[kStatusError]) return Condition::kError;
  if (status[kStatusReset]) return Condition::kNotCalibrated;
  if (status[kStatusWristDetected] && !status[kStatusWristInit]) {
    return Condition::kWristNotCalibrated;
  }
  if (status[kStatusForce]) return Condition::kReady;
  // The arm keeps the last cause when its force is back, so it counts only without.
  if (const int cause = status[kStatusForceOffCause]; cause != 0) {
    const int first = static_cast<int>(Condition::kOffByButton) - 1;
    return cause >= 1 && cause <= 6 ? static_cast<Condition>(first + cause)
                                    : Condition::kOffUnknown;
  }
  if (status[kStatusBrake]) return Condition::kBrake;
  return status[kStatusIdle] ? Condition::kIdle : Condition::kForceOff;
}

std::string DescribeCondition(Condition condition) {
  if (condition == Condition::kReady) return "";
  const ConditionText& text = TextOf(condition);
  return std::string(text.name) + ": " + text.remedy;
}

}  // namespace palpate::dhd
