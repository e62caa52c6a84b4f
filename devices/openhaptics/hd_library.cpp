#include "devices/openhaptics/hd_library.h"

#include "devices/vendor_library.h"

namespace palpate::hd {
namespace {

const VendorLibraryWords& Words() {
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

}  // namespace

std::vector<std::string> LibraryCandidates() {
  return VendorLibraryCandidates(kLibraryVariable, {"libHD.so", "libHD.so.3.5", "libHD.so.3.4",
                                                    "libHD.so.3.3", "libHD.so.3.0"});
}

Library LoadLibrary(const std::vector<std::string>& candidates) {
  const VendorLibrary library = LoadVendorLibrary(candidates, Words());
  Functions functions;
  VendorFunctions names(library);
#define PALPATE_HD_BIND(result, name, arguments) names.Bind(functions.name, #name);
  PALPATE_HD_FUNCTIONS(PALPATE_HD_BIND)
#undef PALPATE_HD_BIND
  names.Check(Words());
  return {library.file, functions};
}

}  // namespace palpate::hd
