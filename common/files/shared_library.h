#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <dlfcn.h>

#include "common/error.h"

namespace palpate {

/// What the messages about a library say that is loaded while a program runs: a vendor's, or one of
/// somebody's own.
struct SharedLibraryWords {
  std::string who;      ///< wants it: "--device NAME", "file:line: field"; begins each message
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
void* LoadSharedLibrary(const std::vector<std::string>& candidates, const SharedLibraryWords& words,
                        std::string& file);

/// Throws Error where it was built for another version of its interface: not of 1 to `known`.
/// @param symbol  what told the version.   @param header  what it is to be built with.
void CheckAbi(std::uint32_t version, std::uint32_t known, const std::string& who,
              const std::string& symbol, const std::string& header);

/// Such a library, with its symbols.
/// @tparam Table  has them as members, and tells each with its name: ForEach(visit).
template <class Table>
struct SharedLibrary {
  std::string file;  ///< as it was found
  Table functions;

  /// Throws Error as LoadSharedLibrary does, and where functions are missing, which it names.
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
