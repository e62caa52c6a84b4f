#pragma once

#include <stdexcept>
#include <string>

namespace palpate {

/// The exception that set-up and tools throw.  Its text tells the user how to act: it names the
/// file, the field and the remedy ("scene.json:12: tools[0].leaves: 0 is not allowed; give at least
/// 1"). The servo path never throws: it is `noexcept` and reports with fault bits (server/physics).
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Thrown if the user's command line is at fault, so that main() can exit with 2 instead of 1.
class UsageError : public Error {
 public:
  using Error::Error;
};

}  // namespace palpate
