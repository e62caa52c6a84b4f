#pragma once

#include <string>
#include <vector>

#include "devices/forcedimension/dhd_abi.h"
#include "devices/vendor_library.h"

namespace palpate::dhd {

/// Names this library's file; its value is then tried alone.
inline constexpr const char* kLibraryVariable = "PALPATE_FORCEDIMENSION_LIBRARY";

inline const VendorLibraryWords& LibraryWords() {
  static const VendorLibraryWords kWords{
      .device = "forcedimension",
      .library = "DHD library",
      .install =
          "install Force Dimension's SDK, 3.7 or later, so that libdhd.so.3 is where the "
          "loader looks (ldconfig)",
      .variable = kLibraryVariable,
      .not_it = "it is not Force Dimension's DHD library, or older than 3.7: install 3.7 or later",
      .remedy_for = [](const std::string& dependency) -> std::string {
        return dependency.starts_with("libusb") ? "apt-get install libusb-1.0-0" : "";
      }};
  return kWords;
}

/// Files to try, in order: the variable's, or else those that the SDK installs.
inline std::vector<std::string> LibraryCandidates() {
  return VendorLibraryCandidates(kLibraryVariable, {"libdhd.so.3", "libdhd.so"});
}

using Library = VendorLibrary<Functions>;

/// Throws Error as VendorLibrary::Load does.
inline Library LoadLibrary(const std::vector<std::string>& candidates) {
  return Library::Load(candidates, LibraryWords());
}

}  // namespace palpate::dhd
