#include "client/course/course_file.h"

#include <system_error>
#include <utility>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

/// Other processes write for milliseconds only, on a slow disk for some more.  At the start a whole
/// check of the file may be waited for; later the caller is the thread that answers everybody.
constexpr int kWaitAtStart_ms = 5000, kWait_ms = 250;
constexpr std::int64_t kTold_ns = 1'000'000'000;

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

/// Lets nobody but its owner open the file: who may read it may also lock it.  SQLite gives the
/// files that it makes beside it the same rights; here they are taken back where an earlier version
/// or a copy gave more.  An existing file is not opened: to close it would end SQLite's locks.
void MakePrivate(const std::string& file) {
  const int made = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (made >= 0) close(made);
  for (const char* ending : {"", "-wal", "-shm", "-journal"}) {
    std::error_code none;  // there is none, or it is another user's: opening it says so
    fs::permissions(file + ending, fs::perms::owner_read | fs::perms::owner_write,
                    fs::perm_options::replace | fs::perm_options::nofollow, none);
  }
}

/// Returns the number of a file on its disk; another file of that name has another one, 0: none.
std::uint64_t NumberOf(const std::string& file) {
  struct stat status {};
  return lstat(file.c_str(), &status) == 0 ? status.st_ino : 0;
}

[[noreturn]] void Rethrow(const std::string& file, const SQLite::Exception& error) {
  const int code = error.getErrorCode();
  const std::string text = fmt::format("{}: {}{}", file, error.what(), RemedyOf(code));
  if (code == SQLITE_BUSY || code == SQLITE_LOCKED) throw CourseHeld(text);
  throw Error(text);
}

}  // namespace

CourseFile::CourseFile(const fs::path& folder) : file_(FileIn(folder)) {
  int version = 0;
  std::string check;
  try {
    MakePrivate(file_);
    // Without links, because SQLite would refuse those in the folder's path, too.
    const std::string path = (fs::canonical(folder) / fs::path(file_).filename()).string();
    opened_ = NumberOf(file_);
    database_ = std::make_unique<SQLite::Database>(
        path, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE | SQLITE_OPEN_NOFOLLOW, kWaitAtStart_ms);
    version = database_->execAndGet("PRAGMA user_version").getInt();
    if (version <= kVersion) {
      check = database_->execAndGet("PRAGMA quick_check(1)").getString();
      database_->exec("PRAGMA journal_mode=WAL");
      database_->exec("PRAGMA synchronous=FULL");
      database_->exec("PRAGMA foreign_keys=ON");
      // Also fails at once if the file cannot be written.
      database_->exec(fmt::format("PRAGMA user_version={}", kVersion));
      database_->setBusyTimeout(kWait_ms);
    }
  } catch (const SQLite::Exception& error) {
    Rethrow(file_, error);
  }
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
  // SQLite would go on writing to a file that no longer has a name.
  if (NumberOf(file_) != opened_) {
    throw Error(file_ +
                ": was replaced or removed while this program had it open, so what it writes would "
                "be lost; end the program, put the file back if it is missing, and start again");
  }
  try {
    action(*database_);
    if (std::exchange(held_since_ns_, 0) != 0) database_->setBusyTimeout(kWait_ms);
    hold_told_ = false;
  } catch (const SQLite::Exception& error) {
    const bool held = error.getErrorCode() == SQLITE_BUSY || error.getErrorCode() == SQLITE_LOCKED;
    if (held) NoteHold();
    Rethrow(file_, error);
  }
}

void CourseFile::Whole(const std::function<void()>& action) {
  Use([&](SQLite::Database& database) {
    SQLite::Transaction transaction(database);
    action();
    transaction.commit();
  });
}

void CourseFile::NoteHold() {
  const std::int64_t now_ns = SteadyNanoseconds();
  if (held_since_ns_ == 0) {
    held_since_ns_ = now_ns;
    database_->setBusyTimeout(0);  // waited for once
  }
  if (now_ns - held_since_ns_ < kTold_ns || std::exchange(hold_told_, true)) return;
  spdlog::warn(
      "{}: another program has held it for a second, and results wait to be written; end "
      "that program",
      file_);
}

}  // namespace palpate
