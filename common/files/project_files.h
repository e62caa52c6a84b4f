#pragma once

#include <string>

namespace palpate {

/// Files that come with the programs.  A program finds them relative to its own location; no path
/// is fixed at build time, so a package, a private prefix and a checkout work alike.
enum class ProjectFile {
  kCatalogue,     ///< folder of the scene files
  kExercises,     ///< folder of the exercises that come with the scenes
  kPage,          ///< folder of the built web page
  kModels,        ///< folder of the npm packages with meshes
  kSharedMemory,  ///< iox-roudi's pools
  kDevicePages,   ///< folder of the pages about arms, to which messages refer
  kRealTimePage,  ///< page on what a host needs for 1 kHz
  kPlots,         ///< script that draws the pictures of palpate-bench's reports
};

/// Returns the folder of the programs: $PALPATE_PROGRAMS if it is set, else that of the running
/// program.  Python, or a user's program that links the library, has no programs beside it;
/// palpate-import is then searched for in the folder given to OfferProgramFolder and on the PATH.
std::string ProgramFolder();

/// Sets the folder in which a Python wheel has installed palpate-import.  Call it before there
/// are threads.
void OfferProgramFolder(const std::string& folder);

/// Returns the working folder; empty if it has been deleted.
std::string WorkingFolder();

/// Returns the path of a file: ../share/palpate, seen from the program's folder, if it is there
/// (installed), else in the checkout in which the program was built, where the program's folder is
/// build/<preset>/bin.  The file need not exist.
/// @param program_folder  ProgramFolder(), except in tests.
std::string PlaceOf(ProjectFile file, const std::string& program_folder = ProgramFolder());

/// Returns the path of a file for a message, in a form that a shell accepts: relative to the
/// working folder if it is below that, and relative to the repository's root if neither the program
/// nor a package contains it (Python's does not).
/// @param program_folder, working_folder  those of the process, except in tests.
std::string ShownPlaceOf(ProjectFile file, const std::string& program_folder = ProgramFolder(),
                         const std::string& working_folder = WorkingFolder());

}  // namespace palpate
