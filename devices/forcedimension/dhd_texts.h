#pragma once

#include <span>
#include <string>

#include "devices/forcedimension/dhd_abi.h"

namespace palpate::dhd {

/// How the driver must react to an error.
enum class ErrorClass {
  kNone,
  kPause,  ///< transient: no force until 0.1 s have passed without an error, then a ramp
  kLatch,  ///< no force until the station is restarted
};

/// An error code of dhdErrorGetLast.
/// @field remedy  what a user can do, as a clause that ends a message.
struct ErrorText {
  int code;
  const char* name;
  ErrorClass error_class;
  const char* remedy;
};

/// Returns all documented codes, in ascending order from zero, for lists and tests.
std::span<const ErrorText> ErrorTexts() noexcept;

/// Returns an error's class; kLatch for an unknown code, because the arm's reaction is then
/// unknown. Real-time.
ErrorClass ClassOf(int code) noexcept;

/// "DHD_ERROR_COM (2): check the cable ..."
std::string DescribeError(int code);

/// The reason why an arm renders no force, according to its status; the first in this order
/// that applies.
enum class Condition {
  kReady,
  kNoPower,
  kNotConnected,
  kNotStarted,
  kError,
  kNotCalibrated,
  kWristNotCalibrated,
  // Causes 1 to 6 for which the arm itself switched its force off (DHD_STATUS_FORCEOFFCAUSE).
  kOffByButton,
  kOffByVelocity,
  kOffByWatchdog,
  kOffBySoftware,
  kOffByUsb,
  kOffByDeadMan,
  kOffUnknown,  ///< a cause unknown to this driver
  kBrake,
  kIdle,
  kForceOff,  ///< for none of these reasons
};

/// @field name    the condition, for the station's table.
/// @field remedy  how to get the force back, as a clause that ends a message.
struct ConditionText {
  Condition condition;
  const char* name;
  const char* remedy;
};

/// Returns all conditions, in their order.
std::span<const ConditionText> ConditionTexts() noexcept;
const ConditionText& TextOf(Condition condition) noexcept;

/// Returns the condition that dhdGetStatus has reported.  Real-time.
/// @param status  kStatusRoom values.
Condition ConditionOf(const int* status) noexcept;

/// "the arm's forces are off by its button: press ..."; "" if it is ready.
std::string DescribeCondition(Condition condition);

}  // namespace palpate::dhd
