#pragma once

#include <string>
#include <vector>

#include "devices/forcedimension/dhd_abi.h"

namespace palpate::dhd {

/// Names this library's file; its value is then tried alone.
inline constexpr const char* kLibraryVariable = "PALPATE_FORCEDIMENSION_LIBRARY";

/// Files to try, in order: the variable's, or else those that the SDK installs.
std::vector<std::string> LibraryCandidates();

struct Library {
  std::string file;  ///< as it was found
  Functions functions;
};

/// Throws Error as LoadVendorLibrary does, and where a function is missing.
Library LoadLibrary(const std::vector<std::string>& candidates);

}  // namespace palpate::dhd
