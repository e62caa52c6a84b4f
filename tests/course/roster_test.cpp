#include "client/course/roster.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/error.h"
#include "tests/support/complaint.h"
#include "tests/support/folder.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::ElementsAre;
using testing::HasSubstr;

class RosterTest : public testing::Test {
 protected:
  /// The names in the file, read as by another process.
  static std::vector<std::string> NamesIn(const std::string& folder) {
    CourseFile file(folder);
    std::vector<std::string> names;
    const Roster roster(file);
    for (const Person& person : roster.people()) names.push_back(person.name);
    return names;
  }
  std::string ComplaintOfMaking(const std::string& name) {
    return ComplaintOf([&] { roster_.Make({name}, Access::kDrive); });
  }

  /// Returns who has the token; null: nobody.
  const Person* HolderOf(const std::string& token) const {
    const auto found = std::ranges::find(roster_.people(), HashOfToken(token), &Person::hash);
    return found == roster_.people().end() || !found->here() ? nullptr : &*found;
  }

  const test::Folder folder_;
  const std::string course_ = folder_ / "course";
  CourseFile file_{course_};
  Roster roster_{file_};
};

TEST_F(RosterTest, KnowsPeopleByTheirTokensAndKeepsOnlyTheirHashes) {
  const auto made = roster_.Make({"Anna", " Ben Müller "}, Access::kDrive);
  const auto teacher = roster_.Make({"teacher"}, Access::kOperate).front();
  ASSERT_EQ(made.size(), 2u);
  EXPECT_EQ(HolderOf(made[1].token)->name, "Ben Müller");
  EXPECT_EQ(HolderOf(teacher.token)->role, Access::kOperate);
  EXPECT_THAT(NamesIn(course_), ElementsAre("Anna", "Ben Müller", "teacher"));
  for (const char* name : {"course.sqlite", "course.sqlite-wal"}) {
    EXPECT_THAT(ReadWholeFile(course_ + "/" + name), Not(HasSubstr(teacher.token.substr(8))));
  }
  EXPECT_EQ(std::filesystem::status(course_).permissions(), std::filesystem::perms::owner_all);
}

TEST_F(RosterTest, RenamesRenewsAndWithdrawsAndNeverGivesAnIdAgain) {
  const auto anna = roster_.Make({"Anna"}, Access::kDrive).front();
  const auto ben = roster_.Make({"Ben"}, Access::kDrive).front();
  roster_.Rename(anna.person.id, "Anne");
  EXPECT_EQ(HolderOf(anna.token)->name, "Anne");
  const auto renewed = roster_.Renew(anna.person.id);
  EXPECT_EQ(HolderOf(anna.token), nullptr);
  EXPECT_EQ(HolderOf(renewed.token)->id, anna.person.id);
  roster_.Withdraw(ben.person.id);
  EXPECT_EQ(HolderOf(ben.token), nullptr);
  EXPECT_EQ(roster_.Find(ben.person.id), nullptr);
  EXPECT_THAT(ComplaintOf([&] { roster_.Rename(ben.person.id, "Bert"); }),
              HasSubstr("no person of this course has the number 2"));
  const auto again = roster_.Make({"Ben"}, Access::kDrive).front();
  EXPECT_EQ(again.person.id, 3);
  EXPECT_EQ(roster_.people().size(), 3u);
}

TEST_F(RosterTest, TellsPeopleApartByWhatTheirNamesLookLike) {
  roster_.Make({"Anna", "Müller", "王伟"}, Access::kDrive);
  EXPECT_EQ(ComplaintOfMaking("Anna"),
            "there is already a 'Anna'; add a letter or number to tell them apart");
  EXPECT_THAT(ComplaintOfMaking("anna"), HasSubstr("'anna' looks like 'Anna'"));
  roster_.Make({"Muller", "李娜"}, Access::kDrive);
  // All or none, also if two of the new ones are alike.
  EXPECT_THAT(ComplaintOf([&] {
                roster_.Make({"Cleo", "Dora", "cleo"}, Access::kDrive);
              }),
              HasSubstr("'cleo' looks like 'Cleo'"));
  EXPECT_EQ(roster_.people().size(), 5u);
  EXPECT_EQ(NamesIn(course_).size(), 5u);
  EXPECT_THAT(ComplaintOf([&] { roster_.Rename(1, "muller"); }), HasSubstr("looks like 'Muller'"));
  roster_.Rename(1, "anna");  // her own name is not taken
  roster_.Rename(1, "Mu\u0308ller 2");
  EXPECT_EQ(roster_.Find(1)->name, "Müller 2");
  EXPECT_EQ(roster_.Find(1)->station, "Muller_2");
}

TEST_F(RosterTest, FindsPeopleByTheirNamesHoweverTheyAreWrittenAndNamesTheNearest) {
  roster_.Make({"José Müller", "Ian", "Lan"}, Access::kDrive);
  for (const char* written : {"José Müller", " Jose\u0301  Mu\u0308ller", "\ufeffjosé MÜLLER"}) {
    ASSERT_NE(roster_.FindName(written), nullptr) << written;
    EXPECT_EQ(roster_.FindName(written)->id, 1);
  }
  EXPECT_EQ(roster_.FindName("Jose Muller"), nullptr);
  EXPECT_EQ(roster_.NameNear("Jose Muller"), "José Müller");
  EXPECT_EQ(roster_.FindName("lan"), nullptr) << "looks like two people's";
  EXPECT_EQ(roster_.FindName("Lan")->id, 3);
  roster_.Withdraw(1);
  EXPECT_EQ(roster_.FindName("José Müller"), nullptr);
}

TEST_F(RosterTest, TakesNoStationThatIsSomebodyElses) {
  const auto is_taken = [](const std::string& station) { return station == "Anna_B"; };
  EXPECT_EQ(roster_.Make({"Anna B"}, Access::kDrive, is_taken)[0].person.station, "Anna_B_1");
  EXPECT_EQ(roster_.Make({"Anna-B"}, Access::kDrive)[0].person.station, "Anna_B");
}

TEST_F(RosterTest, KeepsTheLastWhoMayOperate) {
  const auto teacher = roster_.Make({"teacher"}, Access::kOperate).front();
  EXPECT_THAT(ComplaintOf([&] { roster_.Withdraw(teacher.person.id); }),
              HasSubstr("'teacher' is the last person with the role"));
  roster_.Make({"tutor"}, Access::kOperate);
  roster_.Withdraw(teacher.person.id);
  EXPECT_TRUE(roster_.has_operator());
}

TEST_F(RosterTest, ChangesNothingOnAFullDiskAndSaysSo) {
  roster_.Make({"Anna"}, Access::kDrive);
  file_.Use([](SQLite::Database& database) { database.exec("PRAGMA max_page_count=1"); });
  std::vector<std::string> many;
  for (int i = 0; i < 200; ++i) many.push_back("student " + std::to_string(i));
  EXPECT_THAT(ComplaintOf([&] { roster_.Make(many, Access::kDrive); }),
              AllOf(HasSubstr("course.sqlite"), HasSubstr("the disk is full: free some space")));
  EXPECT_EQ(roster_.people().size(), 1u);
  EXPECT_THAT(NamesIn(course_), ElementsAre("Anna"));
}

TEST_F(RosterTest, IsThereAfterItsProcessWasKilled) {
  const std::string course = folder_ / "killed";
  int told[2];
  ASSERT_EQ(pipe(told), 0);
  const pid_t child = fork();
  if (child == 0) {
    CourseFile file(course);
    Roster roster(file);
    for (int i = 0;; ++i) {
      roster.Make({"student " + std::to_string(i)}, Access::kDrive);
      if (write(told[1], "x", 1) != 1) _exit(1);
    }
  }
  close(told[1]);
  char answers[20];
  std::size_t answered = 0;
  while (answered < sizeof answers) {
    const ssize_t more = read(told[0], answers, sizeof answers - answered);
    ASSERT_GT(more, 0);
    answered += static_cast<std::size_t>(more);
  }
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(told[0]);
  EXPECT_GE(NamesIn(course).size(), answered);
}

TEST(CourseFile, IsRefusedWhereItIsNewerDamagedOrCannotBeWritten) {
  const test::Folder folder;
  const auto complaint = [](const std::string& course) {
    return ComplaintOf([&] { CourseFile file(course); });
  };
  {
    CourseFile file(folder / "newer");
    file.Use([](SQLite::Database& database) { database.exec("PRAGMA user_version=7"); });
  }
  EXPECT_THAT(complaint(folder / "newer"),
              HasSubstr("was written by a newer Palpate (table version 7"));
  {
    CourseFile file(folder / "damaged");
    Roster(file).Make({"Anna"}, Access::kDrive);
  }
  std::fstream damaged(folder / "damaged/course.sqlite", std::ios::in | std::ios::out);
  damaged.seekp(4096) << std::string(4096, 'x') << std::flush;
  EXPECT_THAT(complaint(folder / "damaged"), HasSubstr("it is damaged: restore it from a copy"));
  std::filesystem::create_directory(folder / "text");
  std::ofstream(folder / "text/course.sqlite") << std::string(4096, 'x');
  EXPECT_THAT(complaint(folder / "text"), HasSubstr("it is damaged"));
  std::ofstream(folder / "file") << "x";
  EXPECT_THAT(complaint(folder / "file"), HasSubstr("cannot create the folder"));
  EXPECT_THAT(complaint("/proc/course"), HasSubstr("cannot create the folder"));
  // A folder in which not even root can write.
  EXPECT_THAT(complaint("/proc/self"), HasSubstr("must be able to write the file and its folder"));
}

}  // namespace
}  // namespace palpate
