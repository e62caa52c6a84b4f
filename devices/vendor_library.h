#pragma once

#include <string>
#include <vector>

#include <dlfcn.h>

#include "common/error.h"

namespace palpate {

/// What the messages about a vendor's library say.
struct VendorLibraryWords {
  std::string device;   ///< as after --device; begins each message
  std::string library;  ///< "HD library"
  std::string install;  ///< the remedy where there is none: "install ..."
  /// Of the environment: names another file, which is then tried alone; null: there is none.
  const char* variable = nullptr;
  std::vector<std::string> files;  ///< to try without it, in their order
  /// Where it has not all functions: what it is then, and the remedy: "it is not ...; install ...".
  std::string not_it;
  /// What brings a library that this one needs in its turn; empty: Debian does.
  std::string (*remedy_for)(const std::string& dependency) = nullptr;

  /// The variable's file alone, or else those that there are.
  std::vector<std::string> Candidates() const;
  /// The end of a remedy.
  std::string OrVariable() const {
    return variable ? std::string(", or name the file in ") + variable : "";
  }
};

/// Loads the first of them that there is.  It stays loaded: such libraries have threads of their
/// own.  Throws Error: no such file (every name that was tried, with the loader's own words), or a
/// library that it needs in its turn is missing.
/// @param file  as it was found.
void* LoadVendorLibrary(const std::vector<std::string>& candidates, const VendorLibraryWords& words,
                        std::string& file);

/// Such a library, with its functions.
/// @tparam Table  has them as members, and tells each with its name: ForEach(visit).
template <class Table>
struct VendorLibrary {
  std::string file;  ///< as it was found
  Table functions;

  /// Throws Error as LoadVendorLibrary does, and where functions are missing, which it names.
  static VendorLibrary Load(const std::vector<std::string>& candidates,
                            const VendorLibraryWords& words) {
    VendorLibrary library;
    void* const handle = LoadVendorLibrary(candidates, words, library.file);
    std::string missing;
    library.functions.ForEach([&]<class Function>(Function*& function, const char* name) {
      function = reinterpret_cast<Function*>(dlsym(handle, name));
      if (!function) missing += (missing.empty() ? "" : ", ") + std::string(name);
    });
    if (missing.empty()) return library;
    dlclose(handle);
    throw Error(words.device + ": " + library.file + " has no " + missing + "; " + words.not_it +
                words.OrVariable());
  }
};

}  // namespace palpate
