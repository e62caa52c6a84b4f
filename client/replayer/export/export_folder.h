#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace palpate {

/// The folder of an export.  It grows as FOLDER.part, and gets its name once it is whole; else what
/// was made in it is gone with this object.
///
/// Nothing that no export made is ever removed or replaced.  A former export is known by its
/// methods.json, which names each file's hash and ends with its own: a file that somebody has added
/// or changed is as good as a stranger's.  Of the former export each file goes that is still as it
/// was made, and then each folder that is empty; of whatever has the name then, the system lets an
/// empty folder alone give way.
/// Thread contract: one thread.
class ExportFolder {
 public:
  /// Each file's hash, by its name within the folder.
  using Made = std::map<std::string, std::string>;

  /// Throws Error where what has the name may not give way to a new export, or FOLDER.part is
  /// there.
  /// @param overwrite  a former export may.
  ExportFolder(const std::string& folder, bool overwrite);
  ~ExportFolder();
  ExportFolder(const ExportFolder&) = delete;
  ExportFolder& operator=(const ExportFolder&) = delete;

  const std::filesystem::path& path() const { return part_; }
  /// A file or a folder that is about to be made in it: its path, for convenience.
  std::filesystem::path Make(const std::filesystem::path& path) { return made_.emplace_back(path); }
  /// @param files  that were made, within it.
  Made HashesOf(const std::vector<std::string>& files) const;
  /// Writes methods.json and gives it its name.  Throws Error where something has come there
  /// meanwhile; then the new export is whole under the name that it grew under.
  /// @param methods  JSON whose "made_by" is kExportMark, and whose "hashes" are HashesOf.
  void Finish(const std::string& methods);

 private:
  std::filesystem::path name_, part_;
  Made former_;
  std::vector<std::filesystem::path> made_;  // each after what it is in
};

}  // namespace palpate
