#pragma once

#include <filesystem>
#include <string>

namespace palpate {

/// The folder of an export.  It grows as FOLDER.part, and gets its name once it is whole; until
/// then it is gone with this object.  Nothing that is there already gives way to it.
/// Thread contract: one thread.
class ExportFolder {
 public:
  /// Throws Error where the name, or FOLDER.part, is taken: an empty folder takes no name.
  explicit ExportFolder(const std::string& folder);
  ~ExportFolder();
  ExportFolder(const ExportFolder&) = delete;
  ExportFolder& operator=(const ExportFolder&) = delete;

  const std::filesystem::path& path() const { return part_; }
  /// Gives it its name.  Throws Error where something has come there meanwhile; then the export is
  /// whole under the name that it grew under.
  void Finish();

 private:
  std::filesystem::path name_, part_;
  bool is_whole_ = false;
};

}  // namespace palpate
