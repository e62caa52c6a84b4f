#pragma once

#include <string>
#include <vector>

#include "common/files/shared_library.h"
#include "devices/forcedimension/dhd_abi.h"

namespace palpate::dhd {

inline constexpr const char* kLibraryVariable = "PALPATE_FORCEDIMENSION_LIBRARY";

inline const SharedLibraryWords kLibraryWords{
    .who = "forcedimension",
    .library = "DHD library",
    .install =
        "install Force Dimension's SDK, 3.7 or later, so that libdhd.so.3 is where the "
        "loader looks (ldconfig)",
    .variable = kLibraryVariable,
    .files = {"libdhd.so.3", "libdhd.so"},
    .not_it = "it is not Force Dimension's DHD library, or older than 3.7: install 3.7 or later",
    .remedy_for = [](const std::string& dependency) -> std::string {
      return dependency.starts_with("libusb") ? "apt-get install libusb-1.0-0" : "";
    }};

using Library = SharedLibrary<Functions>;

/// Throws Error as SharedLibrary::Load does.
inline Library LoadLibrary(
    const std::vector<std::string>& candidates = kLibraryWords.Candidates()) {
  return Library::Load(candidates, kLibraryWords);
}

}  // namespace palpate::dhd
