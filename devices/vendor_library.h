#pragma once

#include <string>
#include <vector>

#include <dlfcn.h>

#include "common/error.h"

namespace palpate {

/// What the messages about a vendor's library say.
struct VendorLibraryWords {
  std::string device;    ///< as after --device; begins each message
  std::string library;   ///< "HD library"
  std::string install;   ///< the remedy where there is none: "install ..."
  std::string variable;  ///< names another file
  /// Where it has not all functions: what it is then, and the remedy: "it is not ...; install ...".
  std::string not_it;
  /// What brings a library that this one needs in its turn; empty: Debian does.
  std::string (*remedy_for)(const std::string& dependency) = nullptr;
};

struct VendorLibrary {
  std::string file;  ///< as it was found
  void* handle = nullptr;
};

/// The variable's file alone, or else these.
std::vector<std::string> VendorLibraryCandidates(const char* variable,
                                                 std::vector<std::string> otherwise);

/// Loads the first of them that there is.  It stays loaded: such libraries have threads of their
/// own.  Throws Error: no such file (every name that was tried, with the loader's own words), or a
/// library that it needs in its turn is missing.
VendorLibrary LoadVendorLibrary(const std::vector<std::string>& candidates,
                                const VendorLibraryWords& words);

/// Binds functions by name, and remembers those that are missing.
class VendorFunctions {
 public:
  explicit VendorFunctions(const VendorLibrary& library) : library_(library) {}

  template <class Function>
  void Bind(Function*& function, const char* name) {
    function = reinterpret_cast<Function*>(dlsym(library_.handle, name));
    if (!function) missing_ += (missing_.empty() ? "" : ", ") + std::string(name);
  }
  /// Unloads the library and throws Error, which names them, where any is missing.
  void Check(const VendorLibraryWords& words) const {
    if (missing_.empty()) return;
    dlclose(library_.handle);
    throw Error(words.device + ": " + library_.file + " has no " + missing_ + "; " + words.not_it +
                ", or name another file in " + words.variable);
  }

 private:
  const VendorLibrary& library_;
  std::string missing_;
};

}  // namespace palpate
