#pragma once

#include <string>
#include <vector>

#include "devices/openhaptics/hd_abi.h"

namespace palpate::hd {

/// Names this library's file; its value is then tried alone.
inline constexpr const char* kLibraryVariable = "PALPATE_OPENHAPTICS_LIBRARY";

/// Files to try, in order: the variable's, or else those that releases of OpenHaptics install.
std::vector<std::string> LibraryCandidates();

struct Library {
  std::string file;  ///< as it was found
  Functions functions;
};

/// Loads the first of them that there is.  It stays loaded: it has threads of its own.
/// Throws Error: no such file (every name that was tried, with the loader's own words), a library
/// that it needs in its turn is missing, or a function is.
Library LoadLibrary(const std::vector<std::string>& candidates);

}  // namespace palpate::hd
