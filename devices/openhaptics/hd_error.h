#pragma once

#include <span>
#include <string>

#include "devices/openhaptics/hd_abi.h"

namespace palpate::hd {

/// What an error asks of the driver, mildest first.
enum class ErrorClass {
  kNone,
  kForce,  ///< too much was asked of the arm: contact is dropped, forces ramp in again
  kWarm,   ///< motors are hot: no force until they have cooled
  kFatal,  ///< device, connection or scheduler: no force until the station is started anew
  kUse,    ///< the library was called wrongly, or is another one: taken as fatal
};

/// An error code of the library.
/// @field remedy  what a person can do, as a clause that ends a message.
struct ErrorText {
  Code code;
  const char* name;
  ErrorClass error_class;
  const char* remedy;
};

/// All codes that are known, for lists and tests.
std::span<const ErrorText> ErrorTexts() noexcept;

/// kUse for a code that is unknown: nobody knows what the arm does then.  Real-time.
ErrorClass ClassOf(Code code) noexcept;

/// "HD_COMM_ERROR (0x302, internal 7): check the cable ..."
std::string Describe(const ErrorInfo& error);

}  // namespace palpate::hd
