#pragma once

#include <string>

namespace palpate {

/// Files that come with the programs, which find them by where they stand themselves: nothing is
/// fixed when they are built, so a package, a prefix of one's own and a checkout work alike.
enum class ProjectFile {
  kCatalogue,     ///< folder of the scenes' files
  kPage,          ///< folder of the built web page
  kModels,        ///< folder of npm's packages with meshes
  kSharedMemory,  ///< iox-roudi's pools
  kHeldHand,      ///< script of a hand that presses and holds, for palpate-bench
};

/// Folder of the running program.
std::string ProgramFolder();

/// Its place: in ../share/palpate of the program's folder where it is there (installed), else in
/// the checkout that the program was built in, of which its folder is build/<preset>/bin.  Need not
/// be there.
/// @param program_folder  ProgramFolder(), but for tests.
std::string PlaceOf(ProjectFile file, const std::string& program_folder = ProgramFolder());

}  // namespace palpate
