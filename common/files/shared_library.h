#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <dlfcn.h>

#include "common/error.h"

namespace palpate {

/// The words for messages about a library that is loaded at run time: a vendor's, or a user's own.
struct SharedLibraryWords {
  std::string who;      ///< what needs it: "--device NAME", "file:line: field"; begins each message
  std::string library;  ///< "HD library"
  std::string install;  ///< the remedy if it is missing: "install ..."
  /// Environment variable that names another file, which alone is then tried; null: none.
  const char* variable = nullptr;
  std::vector<std::string> files;  ///< to try, in this order, if the variable is not set
  /// What the library is if functions are missing, and the remedy: "it is not ...; install ...".
  std::string not_it;
  /// Returns how to install a library that this one depends on; empty: it is in Debian.
  std::string (*remedy_for)(const std::string& dependency) = nullptr;

  /// Returns the files to try: the variable's alone if it is set, else `files`.
  std::vector<std::string> Candidates() const;
  /// Returns the end of a remedy that names the variable; empty if there is none.
  std::string OrVariable() const {
    return variable ? std::string(", or name the file in ") + variable : "";
  }
};

/// Loads the first candidate that exists.  It stays loaded, because such libraries have their own
/// threads.  Throws Error if no candidate exists (names each one tried, with the loader's message),
/// or if a library that it depends on is missing.
/// @param file  out: the name that was loaded.
void* LoadSharedLibrary(const std::vector<std::string>& candidates, const SharedLibraryWords& words,
                        std::string& file);

/// Throws Error if the library was built for a version of the interface that is not 1 to `known`.
/// @param symbol  function that returned the version.
/// @param header  the header to build it with.
void CheckAbi(std::uint32_t version, std::uint32_t known, const std::string& who,
              const std::string& symbol, const std::string& header);

/// A library loaded at run time, with its functions.
/// @tparam Table  has the functions as members; ForEach(visit) calls visit(member, name) for each.
template <class Table>
struct SharedLibrary {
  std::string file;  ///< the name that was loaded
  Table functions;

  /// Throws Error as LoadSharedLibrary does, and if functions are missing, which it names.
  static SharedLibrary Load(const std::vector<std::string>& candidates,
                            const SharedLibraryWords& words) {
    SharedLibrary library;
    void* const handle = LoadSharedLibrary(candidates, words, library.file);
    std::string missing;
    library.functions.ForEach([&]<class Function>(Function*& function, const char* name) {
      function = reinterpret_cast<Function*>(dlsym(handle, name));
      if (!function) missing += (missing.empty() ? "" : ", ") + std::string(name);
    });
    if (missing.empty()) return library;
    dlclose(handle);
    throw Error(words.who + ": " + library.file + " has no " + missing + "; " + words.not_it +
                words.OrVariable());
  }
};

}  // namespace palpate
