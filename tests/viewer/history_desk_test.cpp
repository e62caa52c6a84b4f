#include "client/viewer/history_desk.h"

#include <boost/asio/io_context.hpp>
#include <gtest/gtest.h>
#include <unistd.h>

#include "client/course/roster.h"
#include "client/course/trial.h"
#include "tests/support/eventually.h"
#include "tests/support/folder.h"

namespace palpate::test {
namespace {

TEST(HistoryWish, IsTheClassOrAPersonAsATextOrAnArchive) {
  EXPECT_EQ(ParseHistoryWish("class.json")->person, 0);
  EXPECT_EQ(ParseHistoryWish("class.csv")->as, HistoryWish::As::kCsv);
  EXPECT_EQ(ParseHistoryWish("class.csv")->csv, CsvAs::kRfc4180);
  EXPECT_EQ(ParseHistoryWish("7.comma.csv")->csv, CsvAs::kDecimalComma);
  EXPECT_EQ(ParseHistoryWish("7.semicolon.csv")->csv, CsvAs::kSemicolon);
  EXPECT_EQ(ParseHistoryWish("17.zip")->person, 17);
  for (const char* other :
       {"", "class", "class.zip", ".json", "0.json", "-1.json", "1 .json", "01x.json",
        "1.json.json", "99999999999999999999.json", "1/../2.json"}) {
    EXPECT_FALSE(ParseHistoryWish(other)) << other;
  }
}

TEST(HistoryWish, IsGrantedToATeacherAndToWhoDidIt) {
  const HistoryWish of_class, own{7, HistoryWish::As::kZip}, others{8, HistoryWish::As::kJson};
  for (const HistoryWish& wish : {of_class, own, others}) {
    EXPECT_TRUE(MayRead(wish, Access::kOperate, 0));
    EXPECT_FALSE(MayRead(wish, Access::kNone, 7));
    // A token of --tokens is no person of the course.
    EXPECT_FALSE(MayRead(wish, Access::kDrive, 0));
    EXPECT_EQ(MayRead(wish, Access::kDrive, 7), wish.person == 7);
    EXPECT_EQ(MayRead(wish, Access::kWatch, 7), wish.person == 7);
  }
}

TEST(HistoryDesk, GivesAPersonsDataToOneAtATime) {
  const Folder course;
  {
    CourseFile file(course.path());
    Roster(file).Make({"Anna", "Ben"}, Access::kDrive);
    const TrialRoom tables({course.path(), course.path(), {}}, file, {});
  }
  boost::asio::io_context io;
  HistoryDesk desk(io, course.path(), {});
  std::vector<HistoryDesk::Answer> answers;
  const auto ask = [&](std::int64_t person) {
    desk.Ask({person, HistoryWish::As::kZip}, false, {},
             [&](HistoryDesk::Answer answer) { answers.push_back(std::move(answer)); });
  };
  const auto wait_for = [&](std::size_t count) {
    return Eventually([&] {
      io.restart();
      io.poll();
      return answers.size() == count;
    });
  };
  ask(1);
  ask(1);
  ASSERT_TRUE(wait_for(2));
  EXPECT_EQ(answers[0].status, 429) << "it is refused at once";
  ASSERT_GE(answers[1].file, 0) << answers[1].text;
  ask(1);
  EXPECT_EQ(answers.at(2).status, 429) << "as long as it is downloaded";
  ask(2);
  ASSERT_TRUE(wait_for(4));
  EXPECT_GE(answers[3].file, 0) << "another's";
  close(answers[1].file);
  answers[1].given.reset();
  ask(1);
  ASSERT_TRUE(wait_for(5));
  EXPECT_GE(answers[4].file, 0);
  close(answers[3].file);
  close(answers[4].file);
}

}  // namespace
}  // namespace palpate::test
