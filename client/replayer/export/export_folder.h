#pragma once

#include <filesystem>
#include <string>

namespace palpate {

/// The output folder of an export.  It is written as FOLDER.part and renamed once it is complete;
/// if the export fails, the destructor removes it.  It replaces nothing that exists, except an
/// empty folder of its name.
/// Thread contract: one thread.
class ExportFolder {
 public:
  /// Throws Error if FOLDER (unless it is an empty folder) or FOLDER.part exists.
  explicit ExportFolder(const std::string& folder);
  ~ExportFolder();
  ExportFolder(const ExportFolder&) = delete;
  ExportFolder& operator=(const ExportFolder&) = delete;

  const std::filesystem::path& path() const { return part_; }
  /// Renames the folder to its final name.  Throws Error if something has taken that name
  /// meanwhile; the complete export then stays in FOLDER.part.
  void Finish();

 private:
  std::filesystem::path name_, part_;
  bool is_whole_ = false;
};

}  // namespace palpate
