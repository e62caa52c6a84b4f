#include "devices/forcedimension/dhd_library.h"

#include "devices/vendor_library.h"

namespace palpate::dhd {
namespace {

const VendorLibraryWords& Words() {
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

}  // namespace

std::vector<std::string> LibraryCandidates() {
  return VendorLibraryCandidates(kLibraryVariable, {"libdhd.so.3", "libdhd.so"});
}

Library LoadLibrary(const std::vector<std::string>& candidates) {
  const VendorLibrary library = LoadVendorLibrary(candidates, Words());
  Functions functions;
  VendorFunctions names(library);
#define PALPATE_DHD_BIND(result, name, arguments) names.Bind(functions.name, #name);
  PALPATE_DHD_FUNCTIONS(PALPATE_DHD_BIND)
#undef PALPATE_DHD_BIND
  names.Check(Words());
  return {library.file, functions};
}

}  // namespace palpate::dhd
