#pragma once

#include <string>
#include <vector>

#include "common/files/shared_library.h"
#include "devices/openhaptics/hd_abi.h"

namespace palpate::hd {

inline constexpr const char* kLibraryVariable = "PALPATE_OPENHAPTICS_LIBRARY";

inline const SharedLibraryWords kLibraryWords{
    .who = "openhaptics",
    .library = "HD library",
    .install = "install OpenHaptics 3.0 or later and the arm's driver",
    .variable = kLibraryVariable,
    .files = {"libHD.so", "libHD.so.3.5", "libHD.so.3.4", "libHD.so.3.3", "libHD.so.3.0"},
    .not_it = "it is not OpenHaptics' HD library, or older than 3.0: install 3.0 or later",
    .remedy_for = [](const std::string& dependency) -> std::string {
      if (!dependency.starts_with("libPHANToMIO")) return "";
      return "it comes with the arm's driver: install that, in the version that OpenHaptics asks "
             "for";
    }};

using Library = SharedLibrary<Functions>;

/// Throws Error as SharedLibrary::Load does.
inline Library LoadLibrary(
    const std::vector<std::string>& candidates = kLibraryWords.Candidates()) {
  return Library::Load(candidates, kLibraryWords);
}

}  // namespace palpate::hd
