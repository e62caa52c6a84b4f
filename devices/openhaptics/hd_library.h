#pragma once

#include <string>
#include <vector>

#include "devices/openhaptics/hd_abi.h"
#include "devices/vendor_library.h"

namespace palpate::hd {

/// Names this library's file; its value is then tried alone.
inline constexpr const char* kLibraryVariable = "PALPATE_OPENHAPTICS_LIBRARY";

inline const VendorLibraryWords& LibraryWords() {
  static const VendorLibraryWords kWords{
      .device = "openhaptics",
      .library = "HD library",
      .install = "install OpenHaptics 3.0 or later and the arm's driver",
      .variable = kLibraryVariable,
      .not_it = "it is not OpenHaptics' HD library, or older than 3.0: install 3.0 or later",
      .remedy_for = [](const std::string& dependency) -> std::string {
        if (!dependency.starts_with("libPHANToMIO")) return "";
        return "it comes with the arm's driver: install that, in the version that OpenHaptics asks "
               "for";
      }};
  return kWords;
}

/// Files to try, in order: the variable's, or else those that releases of OpenHaptics install.
inline std::vector<std::string> LibraryCandidates() {
  return VendorLibraryCandidates(kLibraryVariable, {"libHD.so", "libHD.so.3.5", "libHD.so.3.4",
                                                    "libHD.so.3.3", "libHD.so.3.0"});
}

using Library = VendorLibrary<Functions>;

/// Throws Error as VendorLibrary::Load does.
inline Library LoadLibrary(const std::vector<std::string>& candidates) {
  return Library::Load(candidates, LibraryWords());
}

}  // namespace palpate::hd
