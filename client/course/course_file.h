#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace SQLite {
class Database;
}

namespace palpate {

/// A course's file, FOLDER/course.sqlite: its people, and what they did.  What has been written is
/// on the disk (WAL, synchronous=FULL): a killed process, or a host without power, loses nothing
/// that was answered.  Each part of a course makes tables of its own there.
/// Thread contract: one thread.  Several processes may have it open.
class CourseFile {
 public:
  /// Of the tables: a file of a newer one is refused, for what it means is not known here.
  static constexpr int kVersion = 1;

  /// Makes folder and file where they are not there, for their owner alone.  Throws Error: the
  /// file, what is wrong with it and the remedy.
  explicit CourseFile(const std::filesystem::path& folder);
  ~CourseFile();

  /// Calls it with the database.  What SQLite refuses becomes an Error that names the file and the
  /// remedy; a transaction within is then undone.
  void Use(const std::function<void(SQLite::Database&)>& action);

 private:
  const std::string file_;
  std::unique_ptr<SQLite::Database> database_;
};

}  // namespace palpate
