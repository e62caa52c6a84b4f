#include "client/course/person_data.h"

#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <minizip/unzip.h>
#include <sys/wait.h>
#include <unistd.h>

#include "client/course/trial_table.h"
#include "tests/support/complaint.h"
#include "tests/support/folder.h"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// Two people with two trials each.
class PersonDataTest : public testing::Test {
 protected:
  PersonDataTest() : course_(folder_ / "course") { Fill(); }
  void Fill() {
    fs::remove_all(course_);
    CourseFile file(course_);
    Roster roster(file);
    roster.Make({"Anna Quartz", "Ben"}, Access::kDrive);
    const TrialTable trials(file);
    file.Use([](SQLite::Database& database) {
      database.exec("CREATE TABLE seals(seal TEXT, person INTEGER);");
      for (const int person : {1, 2}) {
        for (const int n : {1, 2}) {
          database.exec(
              fmt::format("INSERT INTO trials(person, exercise, n, begun_s, ended_s) "
                          "VALUES({}, 'walk', {}, 1, 2)",
                          person, n));
        }
        database.exec(fmt::format("INSERT INTO seals VALUES('x', {})", person));
      }
    });
    for (const int person : {1, 2}) {
      for (const int n : {1, 2}) {
        const fs::path trial = FolderOf(person) / std::to_string(n);
        fs::create_directories(trial);
        std::ofstream(trial / "score.html") << "page " << person << " " << n;
        std::ofstream(trial.string() + ".mcap") << std::string(100'000, 'x');
      }
    }
  }
  fs::path FolderOf(int person) const {
    return fs::path(course_) / "trials" / std::to_string(person) / "walk";
  }
  static bool IsWhole(const fs::path& walk) {
    return fs::exists(walk / "1.mcap") && fs::exists(walk / "2.mcap") &&
           fs::exists(walk / "1/score.html") && fs::exists(walk / "2/score.html");
  }
  static std::vector<int> OwnersOf(CourseFile& file, const std::string& table) {
    std::vector<int> people;
    file.Use([&](SQLite::Database& database) {
      SQLite::Statement rows(database, "SELECT DISTINCT person FROM " + table + " ORDER BY 1");
      while (rows.executeStep()) people.push_back(rows.getColumn(0).getInt());
    });
    return people;
  }
  const Folder folder_;
  const std::string course_;
};

TEST_F(PersonDataTest, IsGivenAsOneZipThatAnybodyOpens) {
  CourseFile file(course_);
  const Roster roster(file);
  const int zip = GiveData(course_, *roster.Find(1), "a,b\r\n");
  unzFile read = unzOpen64(fmt::format("/proc/self/fd/{}", zip).c_str());
  ASSERT_NE(read, nullptr);
  std::map<std::string, std::string> files;
  for (int at = unzGoToFirstFile(read); at == UNZ_OK; at = unzGoToNextFile(read)) {
    std::array<char, 200> name{};
    unz_file_info64 info{};
    unzGetCurrentFileInfo64(read, &info, name.data(), name.size(), nullptr, 0, nullptr, 0);
    EXPECT_EQ(info.compression_method, 0u) << "stored";
    std::string& text = files[name.data()];
    text.resize(info.uncompressed_size);
    unzOpenCurrentFile(read);
    unzReadCurrentFile(read, text.data(), static_cast<unsigned>(text.size()));
    EXPECT_EQ(unzCloseCurrentFile(read), UNZ_OK) << "its sum is right";
  }
  unzClose(read);
  close(zip);
  EXPECT_EQ(files.size(), 6u) << "his are not hers";
  EXPECT_EQ(files["Anna Quartz/walk/2/score.html"], "page 1 2");
  EXPECT_EQ(files["Anna Quartz/walk/1.mcap"].size(), 100'000u);
  EXPECT_EQ(files["Anna Quartz/trials.csv"], "a,b\r\n");
  EXPECT_THAT(files["Anna Quartz/README.txt"], HasSubstr("score.html"));
  for (const auto& entry : fs::directory_iterator(course_)) {
    EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr("given")));
  }
}

TEST_F(PersonDataTest, IsNotGivenWhereItWouldTakeTheSpaceOfRecordings) {
  CourseFile file(course_);
  const Roster roster(file);
  const std::uintmax_t there = fs::space(course_).available;
  EXPECT_THAT(ComplaintOf([&] { GiveData(course_, *roster.Find(1), "", there); }),
              HasSubstr("kept for recordings"));
  close(GiveData(course_, *roster.Find(1), "", 0));
}

TEST_F(PersonDataTest, DoesNotHoldWhatALinkLeadsTo) {
  std::ofstream(folder_ / "secret") << "secret";
  fs::create_directory(folder_ / "others");
  std::ofstream(folder_ / "others/secret") << "secret";
  const fs::path page = FolderOf(1) / "2/score.html";
  fs::remove(page);
  fs::create_symlink(folder_ / "secret", page);
  fs::create_directory_symlink(folder_ / "others", FolderOf(1) / "3");
  CourseFile file(course_);
  const Roster roster(file);
  const auto given = [&] {
    const int zip = GiveData(course_, *roster.Find(1), "a,b\r\n", 0);
    std::string bytes(static_cast<std::size_t>(lseek(zip, 0, SEEK_END)), '\0');
    EXPECT_EQ(pread(zip, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
    close(zip);
    return bytes;
  };
  EXPECT_THAT(given(), testing::AllOf(Not(HasSubstr("secret")), HasSubstr("page 1 1")));
  // Nor where the person's whole folder is one.
  fs::rename(folder_ / "course/trials/1", folder_ / "moved");
  fs::create_directory_symlink(folder_ / "moved", folder_ / "course/trials/1");
  EXPECT_THAT(ComplaintOf([&] { given(); }), HasSubstr("is a link"));
}

TEST_F(PersonDataTest, IsDeletedWhereverItStands) {
  CourseFile file(course_);
  Roster roster(file);
  DeletePerson(file, course_, 1);
  roster.Read();
  EXPECT_EQ(roster.people().size(), 1u);
  EXPECT_THAT(OwnersOf(file, "trials"), ElementsAre(2));
  EXPECT_THAT(OwnersOf(file, "seals"), ElementsAre(2)) << "of whatever part of a course it is";
  EXPECT_THAT(OwnersOf(file, "deleted"), IsEmpty());
  EXPECT_FALSE(fs::exists(FolderOf(1).parent_path()));
  EXPECT_TRUE(IsWhole(FolderOf(2)));
  for (const char* name : {"course.sqlite", "course.sqlite-wal"}) {
    const auto bytes = BytesOf(course_ + "/" + name);
    EXPECT_THAT(std::string(bytes.begin(), bytes.end()), Not(HasSubstr("Quartz"))) << name;
  }
  EXPECT_EQ(roster.Make({"Cleo"}, Access::kDrive).front().person.id, 3)
      << "no number is given again";
}

TEST_F(PersonDataTest, IsNeverHalfThereWhereItsDeletionIsKilled) {
  for (int after_us = 0; after_us < 12'000; after_us += 1'500) {
    Fill();
    const pid_t child = fork();
    if (child == 0) {
      CourseFile file(course_);
      DeletePerson(file, course_, 1);
      _exit(0);
    }
    usleep(static_cast<useconds_t>(after_us));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    CourseFile file(course_);
    const Roster roster(file);
    const bool listed = roster.Find(1) != nullptr;
    EXPECT_EQ(!TrialTable(file).Ended(1).empty(), listed);
    EXPECT_TRUE(!listed || IsWhole(FolderOf(1)));
    FinishDeletions(file, course_);
    EXPECT_EQ(fs::exists(FolderOf(1).parent_path()), listed) << after_us;
    EXPECT_TRUE(IsWhole(FolderOf(2)));
  }
}

}  // namespace
}  // namespace palpate::test
