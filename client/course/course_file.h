#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "common/error.h"

namespace SQLite {
class Database;
}

namespace palpate {

/// Another program holds the course's file: nothing was written, and a later try may succeed.
class CourseHeld : public Error {
 public:
  using Error::Error;
};

/// The file of a course, FOLDER/course.sqlite: its people and their results.  A completed write is
/// on the disk (WAL, synchronous=FULL), so neither a killed process nor a power failure loses
/// anything that was confirmed.  A class for each table (…_table.h) creates and uses it.
/// Thread contract: one thread.  Several processes may have the file open.
class CourseFile {
 public:
  /// The version of the tables.  A file with a newer version is refused.
  static constexpr int kVersion = 1;

  /// Creates the folder and the file if they are missing.  The file and what SQLite makes beside it
  /// are its owner's only (0600), also where they were there before.  Throws Error that names the
  /// file, the fault and the remedy.
  explicit CourseFile(const std::filesystem::path& folder);
  ~CourseFile();

  /// Calls `action` with the database.  An SQLite failure becomes an Error that names the file and
  /// the remedy; a transaction within `action` is then rolled back.  Throws CourseHeld if another
  /// program holds the file for a quarter of a second, and from then on at once, until it lets go;
  /// after a second a line of the log says so.  Throws Error, too, once another file has its name.
  void Use(const std::function<void(SQLite::Database&)>& action);
  /// Makes all changes of `action`, which uses this file, or if it throws none.  Throws as Use
  /// does.
  void Whole(const std::function<void()>& action);

 private:
  void NoteHold();

  const std::string file_;
  std::uint64_t opened_ = 0;  // NumberOf the file
  std::unique_ptr<SQLite::Database> database_;
  std::int64_t held_since_ns_ = 0;  // 0: it is not held
  bool hold_told_ = false;
};

}  // namespace palpate
