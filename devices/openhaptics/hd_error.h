#pragma once

#include <span>
#include <string>

#include "devices/openhaptics/hd_abi.h"

namespace palpate::hd {

/// How the driver must react to an error, mildest first.
enum class ErrorClass {
  kNone,
  kForce,  ///< the command exceeded a limit of the arm: the force is dropped and ramps in again
  kWarm,   ///< motors are hot: no force until they have cooled
  kFatal,  ///< device, connection or scheduler failed: no force until the station is restarted
  kUse,    ///< the library was called wrongly, or is a different one: treated as fatal
};

/// An error code of the library.
/// @field remedy  what a user can do, as a clause that ends a message.
struct ErrorText {
  Code code;
  const char* name;
  ErrorClass error_class;
  const char* remedy;
};

/// Returns all known codes, for lists and tests.
std::span<const ErrorText> ErrorTexts() noexcept;

/// Returns an error's class; kUse for an unknown code, because the arm's reaction is then
/// unknown. Real-time.
ErrorClass ClassOf(Code code) noexcept;

/// "HD_COMM_ERROR (0x302, internal 7): check the cable ..."
std::string Describe(const ErrorInfo& error);

}  // namespace palpate::hd
