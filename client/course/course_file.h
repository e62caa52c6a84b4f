#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace SQLite {
class Database;
}

namespace palpate {

/// The file of a course, FOLDER/course.sqlite: its people and their results.  A completed write is
/// on the disk (WAL, synchronous=FULL), so neither a killed process nor a power failure loses
/// anything that was confirmed.  Each part of a course creates its own tables there.
/// Thread contract: one thread.  Several processes may have the file open.
class CourseFile {
 public:
  /// The version of the tables.  A file with a newer version is refused.
  static constexpr int kVersion = 1;

  /// Creates the folder and the file if they are missing, readable by their owner only.  Throws
  /// Error that names the file, the fault and the remedy.
  explicit CourseFile(const std::filesystem::path& folder);
  ~CourseFile();

  /// Calls `action` with the database.  An SQLite failure becomes an Error that names the file and
  /// the remedy; a transaction within `action` is then rolled back.
  void Use(const std::function<void(SQLite::Database&)>& action);

 private:
  const std::string file_;
  std::unique_ptr<SQLite::Database> database_;
};

}  // namespace palpate
