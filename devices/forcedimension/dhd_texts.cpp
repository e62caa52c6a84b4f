#include "devices/forcedimension/dhd_texts.h"

#include <array>

namespace palpate::dhd {
namespace {

constexpr const char* kReport =
    "the driver called the library in a way that this version refuses; please report it, with the "
    "library's version";

/// In the order of the codes: 0, 1, 2, ...
constexpr std::array<ErrorText, 23> kErrors{{
    {0, "DHD_NO_ERROR", ErrorClass::kNone, "nothing to do"},
    {1, "DHD_ERROR", ErrorClass::kLatch,
     "the library gives no reason: switch the arm off and on, try it with its vendor's HapticDesk, "
     "and start the station again"},
    {2, "DHD_ERROR_COM", ErrorClass::kLatch,
     "the arm does not answer: check its USB cable (no hub) and power, and start the station "
     "again"},
    {3, "DHD_ERROR_DHC_BUSY", ErrorClass::kPause,
     "the arm's controller is busy; if this persists, end other programs that use it, and switch "
     "it off and on"},
    {4, "DHD_ERROR_NO_DRIVER_FOUND", ErrorClass::kLatch,
     "the library finds no USB driver: install libusb-1.0-0, and the SDK's udev rules"},
    {5, "DHD_ERROR_NO_DEVICE_FOUND", ErrorClass::kLatch,
     "switch the arm on and plug it in ('lsusb -d 1451:' shows it), and let this user open it: "
     "a udev rule with SUBSYSTEM==\"usb\", ATTR{idVendor}==\"1451\", MODE=\"0666\""},
    {6, "DHD_ERROR_NOT_AVAILABLE", ErrorClass::kLatch,
     "this arm or its firmware does not support the request: update its firmware with its vendor's "
     "program"},
    {7, "DHD_ERROR_TIMEOUT", ErrorClass::kPause,
     "an answer came late: if this persists, use another USB port without a hub, and end programs "
     "that load the machine"},
    {8, "DHD_ERROR_GEOMETRY", ErrorClass::kPause,
     "the joint angles are inconsistent at this pose: move the handle towards the middle; if this "
     "persists, calibrate the arm again (--calibrate)"},
    {9, "DHD_ERROR_EXPERT_MODE_DISABLED", ErrorClass::kLatch, kReport},
    {10, "DHD_ERROR_NOT_IMPLEMENTED", ErrorClass::kLatch,
     "this version of the library does not know the function: install the newest SDK"},
    {11, "DHD_ERROR_OUT_OF_MEMORY", ErrorClass::kLatch,
     "the machine has no memory left: end other programs, and start the station again"},
    {12, "DHD_ERROR_DEVICE_NOT_READY", ErrorClass::kPause,
     "the arm is still starting, or is not calibrated: wait until its light stops blinking, or put "
     "the handle into its rest position"},
    {13, "DHD_ERROR_FILE_NOT_FOUND", ErrorClass::kLatch,
     "the arm's calibration file is missing: install it again with its vendor's program"},
    {14, "DHD_ERROR_CONFIGURATION", ErrorClass::kLatch,
     "the arm's own configuration cannot be read: check it with its vendor's HapticDesk, or ask "
     "its vendor"},
    {15, "DHD_ERROR_INVALID_INDEX", ErrorClass::kLatch,
     "no arm has this number any more: it was unplugged or closed; start the station again"},
    {16, "DHD_ERROR_DEPRECATED", ErrorClass::kLatch,
     "the library does not serve this function or this old arm any more: install the SDK that came "
     "with the arm"},
    {17, "DHD_ERROR_NULL_ARGUMENT", ErrorClass::kLatch, kReport},
    {18, "DHD_ERROR_REDUNDANT_FAIL", ErrorClass::kLatch,
     "the arm's two encoders of a joint disagree: switch it off, do not use it, and ask its "
     "vendor"},
    {19, "DHD_ERROR_NOT_ENABLED", ErrorClass::kPause,
     "the arm's forces are not enabled: press its force button, or its pedal, and hold the handle"},
    {20, "DHD_ERROR_DEVICE_IN_USE", ErrorClass::kLatch,
     "another program has the arm: end it, a HapticDesk or another station say"},
    {21, "DHD_ERROR_INVALID", ErrorClass::kLatch, kReport},
    {22, "DHD_ERROR_NO_REGULATION", ErrorClass::kLatch,
     "the library's robotic regulation was asked for, which the driver does not use: end the "
     "program that shares the arm"},
}};

const ErrorText* Find(int code) noexcept {
  const bool known = code >= 0 && code < static_cast<int>(kErrors.size());
  return known ? &kErrors[static_cast<std::size_t>(code)] : nullptr;
}

constexpr std::array<ConditionText, 17> kConditions{{
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
     "the arm received no command for too long: find out why the station was delayed "
     "(palpate-doctor), then press the arm's force button"},
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

std::span<const ErrorText> ErrorTexts() noexcept {
  return kErrors;
}

ErrorClass ClassOf(int code) noexcept {
  const ErrorText* text = Find(code);
  return text ? text->error_class : ErrorClass::kLatch;
}

std::string DescribeError(int code) {
  const ErrorText* text = Find(code);
  return std::string(text ? text->name : "an unknown error") + " (" + std::to_string(code) +
         "): " + (text ? text->remedy : kReport);
}

std::span<const ConditionText> ConditionTexts() noexcept {
  return kConditions;
}

const ConditionText& TextOf(Condition condition) noexcept {
  return kConditions[static_cast<std::size_t>(condition)];
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
  // The arm still reports the last cause after its force has returned, so the cause counts only
  // while forces are off.
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
