#include "devices/openhaptics/hd_library.h"

#include <cstdlib>
#include <filesystem>

#include <dlfcn.h>

#include "common/error.h"

namespace palpate::hd {
namespace {

/// What else the loader asks for: "libncurses.so.5: cannot open shared object file: ..." while it
/// was asked for another file.  Empty where that is not what it says.
std::string MissingDependency(const std::string& message, const std::string& file) {
  static const std::string kCannotOpen = ": cannot open shared object file";
  const std::size_t end = message.find(kCannotOpen);
  if (end == std::string::npos || message.compare(0, end, file) == 0) return "";
  return message.substr(0, end);
}

std::string RemedyFor(const std::string& dependency) {
  if (dependency.starts_with("libPHANToMIO")) {
    return "it comes with the arm's driver: install that, in the version that OpenHaptics asks for";
  }
  return "install the package that has " + dependency + " ('apt-file search " + dependency + "')";
}

Functions Bind(void* library, const std::string& file) {
  Functions functions;
  std::string missing;
  const auto bind = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
    if (!function) missing += (missing.empty() ? "" : ", ") + std::string(name);
  };
#define PALPATE_HD_BIND(result, name, arguments) bind(functions.name, #name);
  PALPATE_HD_FUNCTIONS(PALPATE_HD_BIND)
#undef PALPATE_HD_BIND
  if (!missing.empty()) {
    dlclose(library);
    throw Error("openhaptics: " + file + " has no " + missing +
                "; it is not OpenHaptics' HD library, or older than 3.0: install 3.0 or later, or "
                "name another file in " +
                kLibraryVariable);
  }
  return functions;
}

}  // namespace

std::vector<std::string> LibraryCandidates() {
  if (const char* file = std::getenv(kLibraryVariable); file && *file) return {file};
  return {"libHD.so", "libHD.so.3.5", "libHD.so.3.4", "libHD.so.3.3", "libHD.so.3.0"};
}

Library LoadLibrary(const std::vector<std::string>& candidates) {
  std::string tried;
  for (const std::string& file : candidates) {
    // NOW: a function that is missing shows here, and not within a frame.
    if (void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
      return {file, Bind(library, file)};
    }
    const char* said = dlerror();
    const std::string message = said ? said : "no reason given";
    if (const std::string needs = MissingDependency(message, file); !needs.empty()) {
      throw Error("openhaptics: " + file + " is there, but needs " + needs +
                  ", which is missing; " + RemedyFor(needs) + " (dlopen: " + message + ")");
    }
    tried += (tried.empty() ? " " : "; ") + file + ": " + message;
  }
  throw Error(
      "openhaptics: no HD library could be loaded; install OpenHaptics 3.0 or later and the arm's "
      "driver, or name the file in " +
      std::string(kLibraryVariable) + ".  Tried:" + tried);
}

}  // namespace palpate::hd
