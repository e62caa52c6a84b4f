#pragma once

#include <span>
#include <string>

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

}  // namespace palpate::dhd
