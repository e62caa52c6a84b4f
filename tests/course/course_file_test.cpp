// The course's file beside others that may open, lock or redirect it.
#include "client/course/course_file.h"

#include <filesystem>
#include <fstream>

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>

#include "tests/support/complaint.h"
#include "tests/support/folder.h"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

void Add(CourseFile& file, int number) {
  file.Use([&](SQLite::Database& database) {
    database.exec("CREATE TABLE IF NOT EXISTS t(n INTEGER)");
    database.exec("INSERT INTO t VALUES(" + std::to_string(number) + ")");
  });
}

TEST(CourseFile, IsItsOwnersOnlyInAFolderThatWasThereAndAfterAnOlderVersion) {
  const Folder course;
  fs::permissions(course.path(), fs::perms::all);
  for (int time = 0; time < 2; ++time) {
    CourseFile file(course.path());
    Add(file, time);
    for (const char* name : {"course.sqlite", "course.sqlite-wal", "course.sqlite-shm"}) {
      EXPECT_EQ(fs::status(course / name).permissions(),
                fs::perms::owner_read | fs::perms::owner_write)
          << name;
      fs::permissions(course / name, fs::perms::others_read, fs::perm_options::add);
    }
  }
}

TEST(CourseFile, IsWaitedForOnceWhileAnotherHoldsItAndThenUsedAgain) {
  const Folder course;
  CourseFile file(course.path());
  Add(file, 1);
  SQLite::Database other(course / "course.sqlite", SQLite::OPEN_READWRITE);
  other.exec("BEGIN IMMEDIATE");
  EXPECT_THROW(Add(file, 2), CourseHeld);
  // Each of these would wait for seconds if it waited as the first does: the test would time out.
  for (int i = 0; i < 2000; ++i) EXPECT_THROW(Add(file, 2), CourseHeld);
  other.exec("COMMIT");
  Add(file, 3);
  file.Use([](SQLite::Database& database) {
    EXPECT_EQ(database.execAndGet("SELECT group_concat(n) FROM t").getString(), "1,3");
  });
}

TEST(CourseFile, WritesNothingThatWouldBeLostOnceAnotherFileHasItsName) {
  const Folder course, copy;
  CourseFile file(course.path());
  Add(file, 1);
  fs::copy_file(course / "course.sqlite", copy / "course.sqlite");
  fs::rename(copy / "course.sqlite", course / "course.sqlite");  // a backup is restored
  EXPECT_THROW(Add(file, 2), Error);
  fs::remove(course / "course.sqlite");
  EXPECT_THROW(Add(file, 3), Error);
}

TEST(CourseFile, IsNotALink) {
  const Folder course, elsewhere;
  std::ofstream(elsewhere / "other").flush();
  fs::create_symlink(elsewhere / "other", course / "course.sqlite");
  EXPECT_NE(ComplaintOf([&] { CourseFile file(course.path()); }), "no complaint");
  EXPECT_EQ(fs::file_size(elsewhere / "other"), 0u);
  // A course's folder itself may be reached by one.
  fs::create_directory(elsewhere / "course");
  fs::create_directory_symlink(elsewhere / "course", elsewhere / "way");
  CourseFile file(elsewhere / "way");
  Add(file, 1);
}

}  // namespace
}  // namespace palpate::test
