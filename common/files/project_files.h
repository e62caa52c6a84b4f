#pragma once

#include <string>

namespace palpate {

/// Files that come with the programs, which find them by where they stand themselves: nothing is
/// fixed when they are built, so a package, a prefix of one's own and a checkout work alike.
enum class ProjectFile {
  kCatalogue,     ///< folder of the scenes' files
  kExercises,     ///< folder of the exercises that come with them
  kPage,          ///< folder of the built web page
  kModels,        ///< folder of npm's packages with meshes
  kSharedMemory,  ///< iox-roudi's pools
  kDevicePages,   ///< folder of the pages about arms, which messages name
  kRealTimePage,  ///< page about what a host needs for 1 kHz
  kPlots,         ///< script that draws the pictures of palpate-bench's reports
};

/// Folder of the programs: what $PALPATE_PROGRAMS names, else that of the running one.  A program
/// of somebody else's, who links the library, or Python, has none of them beside it: then what was
/// offered and the PATH are asked where palpate-import is.
std::string ProgramFolder();

/// Where a wheel of Python has brought palpate-import.  To be called before there are threads.
void OfferProgramFolder(const std::string& folder);

/// Empty where it is gone.
std::string WorkingFolder();

/// Its place: in ../share/palpate of the program's folder where it is there (installed), else in
/// the checkout that the program was built in, of which its folder is build/<preset>/bin.  Need not
/// be there.
/// @param program_folder  ProgramFolder(), but for tests.
std::string PlaceOf(ProjectFile file, const std::string& program_folder = ProgramFolder());

/// Its place for a message, in a form that a shell takes: from the working folder where it is below
/// that, and from the repository's root where neither program nor package has it (Python's does
/// not).
/// @param program_folder, working_folder  the process's, but for tests.
std::string ShownPlaceOf(ProjectFile file, const std::string& program_folder = ProgramFolder(),
                         const std::string& working_folder = WorkingFolder());

}  // namespace palpate
