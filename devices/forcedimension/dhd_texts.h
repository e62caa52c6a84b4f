#pragma once

#include <span>
#include <string>

#include "devices/forcedimension/dhd_abi.h"

namespace palpate::dhd {

/// What an error asks of the driver.
enum class ErrorClass {
  kNone,
  kPause,  ///< passes by itself: no force until 0.1 s without one have passed, then a ramp
  kLatch,  ///< no force until the station is started again
};

/// An error code of dhdErrorGetLast.
/// @field remedy  what a person can do, as a clause that ends a message.
struct ErrorText {
  int code;
  const char* name;
  ErrorClass error_class;
  const char* remedy;
};

/// All codes that are documented, by code from zero up, for lists and tests.
std::span<const ErrorText> ErrorTexts() noexcept;

/// kLatch for a code that is unknown: nobody knows what the arm does then.  Real-time.
ErrorClass ClassOf(int code) noexcept;

/// "DHD_ERROR_COM (2): check the cable ..."
std::string DescribeError(int code);

/// Why an arm renders no force, as its status says; the first that holds, in this order.
enum class Condition {
  kReady,
  kNoPower,
  kNotConnected,
  kNotStarted,
  kError,
  kNotCalibrated,
  kWristNotCalibrated,
  // Causes 1 to 6 for which the arm itself took its force away (DHD_STATUS_FORCEOFFCAUSE).
  kOffByButton,
  kOffByVelocity,
  kOffByWatchdog,
  kOffBySoftware,
  kOffByUsb,
  kOffByDeadMan,
  kOffUnknown,  ///< one that this driver does not know
  kBrake,
  kIdle,
  kForceOff,  ///< for none of these reasons
};

/// @field name    what it is, for the station's table.
/// @field remedy  how the force comes back, as a clause that ends a message.
struct ConditionText {
  Condition condition;
  const char* name;
  const char* remedy;
};

/// All of them, in their order.
std::span<const ConditionText> ConditionTexts() noexcept;
const ConditionText& TextOf(Condition condition) noexcept;

/// Of what dhdGetStatus gave.  Real-time.
/// @param status  kStatusRoom values.
Condition ConditionOf(const int* status) noexcept;

/// "the arm's forces are off by its button: press ..."; "" where it is ready.
std::string DescribeCondition(Condition condition);

}  // namespace palpate::dhd
