#include "devices/openhaptics/hd_error.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace palpate::hd {
namespace {

constexpr const char* kReport =
    "the driver called the library in a way that this version refuses; please report it, with the "
    "library's version";

constexpr std::array<ErrorText, 22> kTexts{{
    {kSuccess, "HD_SUCCESS", ErrorClass::kNone, "nothing to do"},
    {kInvalidEnum, "HD_INVALID_ENUM", ErrorClass::kUse, kReport},
    {kInvalidValue, "HD_INVALID_VALUE", ErrorClass::kUse, kReport},
    {kInvalidOperation, "HD_INVALID_OPERATION", ErrorClass::kUse, kReport},
    {kInvalidInputType, "HD_INVALID_INPUT_TYPE", ErrorClass::kUse, kReport},
    {kBadHandle, "HD_BAD_HANDLE", ErrorClass::kUse,
     "no device answers to its handle; check power and cable, and start the station again"},
    {kWarmMotors, "HD_WARM_MOTORS", ErrorClass::kWarm,
     "let the arm rest, without touching anything, until its motors have cooled"},
    {kExceededMaxForce, "HD_EXCEEDED_MAX_FORCE", ErrorClass::kForce,
     "press less hard, or give the scene a softer coupling"},
    {kExceededMaxForceImpulse, "HD_EXCEEDED_MAX_FORCE_IMPULSE", ErrorClass::kForce,
     "touch less abruptly, or give the scene a softer coupling"},
    {kExceededMaxVelocity, "HD_EXCEEDED_MAX_VELOCITY", ErrorClass::kForce,
     "hold the stylus and move it slower"},
    {kForceError, "HD_FORCE_ERROR", ErrorClass::kForce,
     "if it comes again without contact, check the arm with its vendor's diagnostic program"},
    {kDeviceFault, "HD_DEVICE_FAULT", ErrorClass::kFatal,
     "switch the arm off and on, check it with its vendor's diagnostic program, and start the "
     "station again"},
    {kDeviceAlreadyInitiated, "HD_DEVICE_ALREADY_INITIATED", ErrorClass::kFatal,
     "the arm is in use: end the other program that drives it, a demo or another station say"},
    {kCommError, "HD_COMM_ERROR", ErrorClass::kFatal,
     "check the arm's cable, power and port, and start the station again"},
    {kCommConfigError, "HD_COMM_CONFIG_ERROR", ErrorClass::kFatal,
     "check the cable, and select the arm's port again in its vendor's set-up program"},
    {kTimerError, "HD_TIMER_ERROR", ErrorClass::kFatal,
     "the library could not keep its rate: ask for a lower --rate, end what loads the "
     "machine, and start the station again"},
    {kIllegalBegin, "HD_ILLEGAL_BEGIN", ErrorClass::kUse, kReport},
    {kIllegalEnd, "HD_ILLEGAL_END", ErrorClass::kUse, kReport},
    {kFrameError, "HD_FRAME_ERROR", ErrorClass::kUse, kReport},
    {kInvalidPriority, "HD_INVALID_PRIORITY", ErrorClass::kUse, kReport},
    {kSchedulerFull, "HD_SCHEDULER_FULL", ErrorClass::kUse, kReport},
    {kInvalidLicense, "HD_INVALID_LICENSE", ErrorClass::kFatal,
     "install a licence of OpenHaptics for this machine with its vendor's licence program; a "
     "deployment licence is not used"},
}};

const ErrorText* Find(Code code) noexcept {
  const auto found = std::find_if(kTexts.begin(), kTexts.end(),
                                  [code](const ErrorText& text) { return text.code == code; });
  return found == kTexts.end() ? nullptr : &*found;
}

}  // namespace

std::span<const ErrorText> ErrorTexts() noexcept {
  return kTexts;
}

ErrorClass ClassOf(Code code) noexcept {
  const ErrorText* text = Find(code);
  return text ? text->error_class : ErrorClass::kUse;
}

std::string Describe(const ErrorInfo& error) {
  const ErrorText* text = Find(error.code);
  char numbers[64];
  std::snprintf(numbers, sizeof numbers, " (0x%x, internal %d): ", error.code, error.internal_code);
  std::string said = text ? text->name : "an unknown error";
  said += numbers;
  said += text ? text->remedy : kReport;
  return said;
}

}  // namespace palpate::hd
