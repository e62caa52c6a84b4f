#include "common/files/shared_library.h"

#include <cstdlib>

#include "common/math/default_rounding.h"

namespace palpate {
namespace {

/// Returns the missing library in a loader's message such as "libncurses.so.5: cannot open shared
/// object file: ..." about another file; empty if the message is a different one.
std::string MissingDependency(const std::string& message, const std::string& file) {
  static const std::string kCannotOpen = ": cannot open shared object file";
  const std::size_t end = message.find(kCannotOpen);
  if (end == std::string::npos || message.compare(0, end, file) == 0) return "";
  return message.substr(0, end);
}

std::string RemedyFor(const std::string& dependency, const SharedLibraryWords& words) {
  const std::string remedy = words.remedy_for ? words.remedy_for(dependency) : "";
  if (!remedy.empty()) return remedy;
  return "install the package that has " + dependency + " ('apt-file search " + dependency + "')";
}

}  // namespace

std::vector<std::string> SharedLibraryWords::Candidates() const {
  if (const char* file = std::getenv(variable); file && *file) return {file};
  return files;
}

void* LoadSharedLibrary(const std::vector<std::string>& candidates, const SharedLibraryWords& words,
                        std::string& file) {
  const DefaultRounding rounding;  // a library built with -ffast-math changes it when loaded
  std::string tried;
  for (const std::string& candidate : candidates) {
    // NOW: a missing function is detected here and not within a tick.
    if (void* handle = dlopen(candidate.c_str(), RTLD_NOW | RTLD_LOCAL)) {
      file = candidate;
      return handle;
    }
    const char* said = dlerror();
    const std::string message = said ? said : "no reason given";
    if (const std::string needs = MissingDependency(message, candidate); !needs.empty()) {
      throw Error(words.who + ": " + candidate + " exists, but needs " + needs +
                  ", which is missing; " + RemedyFor(needs, words) + " (dlopen: " + message + ")");
    }
    tried += (tried.empty() ? " " : "; ") + candidate + ": " + message;
  }
  throw Error(words.who + ": no " + words.library + " could be loaded; " + words.install +
              words.OrVariable() + ".  Tried:" + tried);
}

void CheckAbi(std::uint32_t version, std::uint32_t known, const std::string& who,
              const std::string& symbol, const std::string& header) {
  if (version > 0 && version <= known) return;
  throw Error(who + ": " + symbol + " is " + std::to_string(version) +
              " but this version supports 1 to " + std::to_string(known) + "; build it with the " +
              header + " of this version of palpate");
}

}  // namespace palpate
