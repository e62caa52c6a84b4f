#include "client/course/course_file.h"

#include <system_error>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include "common/error.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

/// Other processes write for milliseconds only.
constexpr int kWait_ms = 5000;

const char* RemedyOf(int code) {
  switch (code) {
    case SQLITE_FULL:
      return "; the disk is full: free some space, and do it again";
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return "; it is damaged: restore it from a copy, or move it and its -wal and -shm files away "
             "to start with an empty course";
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return "; another program holds it: end that one, and do it again";
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      return "; this user must be able to write the file and its folder: give him both, or another "
             "--course";
    default:
      return "; look whether its disk is full or fails";
  }
}

std::string FileIn(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error) && fs::create_directories(folder, error)) {
    fs::permissions(folder, fs::perms::owner_all, error);  // names and marks are private
  }
  if (error || !fs::is_directory(folder, error)) {
    throw Error(fmt::format("--course {}: cannot create the folder{}; give another",
                            folder.string(), error ? " (" + error.message() + ")" : ""));
  }
  return (folder / "course.sqlite").string();
}

}  // namespace

CourseFile::CourseFile(const fs::path& folder) : file_(FileIn(folder)) {
  int version = 0;
  std::string check;
  Use([&](SQLite::Database&) {
    database_ = std::make_unique<SQLite::Database>(
        file_, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE, kWait_ms);
    version = database_->execAndGet("PRAGMA user_version").getInt();
    if (version > kVersion) return;
    check = database_->execAndGet("PRAGMA quick_check(1)").getString();
    database_->exec("PRAGMA journal_mode=WAL");
    database_->exec("PRAGMA synchronous=FULL");
    database_->exec("PRAGMA foreign_keys=ON");
    // Also fails at once if the file cannot be written.
    database_->exec(fmt::format("PRAGMA user_version={}", kVersion));
  });
  if (version > kVersion) {
    throw Error(
        fmt::format("{}: was written by a newer Palpate (table version {}; this one supports up to "
                    "{}); use that version, or give another --course",
                    file_, version, kVersion));
  }
  if (check != "ok") {
    throw Error(fmt::format("{}: {}{}", file_, check, RemedyOf(SQLITE_CORRUPT)));
  }
}

CourseFile::~CourseFile() = default;

void CourseFile::Use(const std::function<void(SQLite::Database&)>& action) {
  try {
    action(*database_);
  } catch (const SQLite::Exception& error) {
    throw Error(fmt::format("{}: {}{}", file_, error.what(), RemedyOf(error.getErrorCode())));
  }
}

}  // namespace palpate
