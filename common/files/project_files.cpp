#include "common/files/project_files.h"

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string_view>

namespace palpate {
namespace {

namespace fs = std::filesystem;

/// @field installed  path below share/palpate.
/// @field checkout  path below the repository's root.
struct Places {
  std::string_view installed, checkout;
};

Places PlacesOf(ProjectFile file) {
  switch (file) {
    case ProjectFile::kCatalogue:
      return {"catalogue", "scenes/catalogue"};
    case ProjectFile::kExercises:
      return {"exercises", "client/course/exercises"};
    case ProjectFile::kPage:
      return {"page", "build/page"};
    case ProjectFile::kModels:
      return {"models/node_modules", "build/models/node_modules"};
    case ProjectFile::kSharedMemory:
      return {"roudi.toml", "deploy/cyclonedds/roudi.toml"};
    case ProjectFile::kDevicePages:
      return {"../doc/palpate-common/devices", "devices"};
    case ProjectFile::kRealTimePage:
      return {"../doc/palpate-common/deploy/REALTIME.md", "deploy/REALTIME.md"};
    case ProjectFile::kPlots:
      return {"plots.py", "tests/benchmarks/plots.py"};
  }
  return {};
}

std::string& Offered() {
  static std::string folder;  // followed by a colon
  return folder;
}

}  // namespace

void OfferProgramFolder(const std::string& folder) {
  Offered() = folder + ':';
}

std::string ProgramFolder() {
  const auto from = [](const char* variable) {
    const char* text = std::getenv(variable);
    return std::string(text == nullptr ? "" : text);
  };
  if (const std::string named = from("PALPATE_PROGRAMS"); !named.empty()) return named;
  std::error_code error;
  const std::string own = fs::read_symlink("/proc/self/exe", error).parent_path().string();
  std::istringstream path(Offered() + own + ':' + from("PATH"));
  for (std::string folder; std::getline(path, folder, ':');) {
    // An empty one, as of PATH=:/usr/bin, would be that of the shell, perhaps a stranger's.
    if (!folder.starts_with('/')) continue;
    const fs::path import = fs::path(folder) / "palpate-import";
    if (fs::exists(import, error)) return fs::canonical(import, error).parent_path().string();
  }
  return own;
}

std::string PlaceOf(ProjectFile file, const std::string& program_folder) {
  const Places places = PlacesOf(file);
  const fs::path folder = program_folder;
  const fs::path installed = folder / "../share/palpate" / places.installed;
  std::error_code ignored;
  if (fs::exists(installed, ignored)) return installed.lexically_normal().string();
  return (folder / "../../.." / places.checkout).lexically_normal().string();
}

std::string WorkingFolder() {
  std::error_code gone;
  return fs::current_path(gone).string();
}

std::string ShownPlaceOf(ProjectFile file, const std::string& program_folder,
                         const std::string& working_folder) {
  const std::string place = PlaceOf(file, program_folder);
  std::error_code ignored;
  if (!fs::exists(place, ignored)) return std::string(PlacesOf(file).checkout);
  const std::string below = working_folder + "/";
  return below != "/" && place.starts_with(below) ? place.substr(below.size()) : place;
}

}  // namespace palpate
