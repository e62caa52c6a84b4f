#include "client/viewer/history_desk.h"

#include <gtest/gtest.h>

namespace palpate::test {
namespace {

TEST(HistoryWish, IsTheClassOrAPersonAsATextOrAnArchive) {
  EXPECT_EQ(ParseHistoryWish("class.json")->person, 0);
  EXPECT_EQ(ParseHistoryWish("class.csv")->as, HistoryWish::As::kCsv);
  EXPECT_EQ(ParseHistoryWish("7.comma.csv")->as, HistoryWish::As::kCommaCsv);
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

}  // namespace
}  // namespace palpate::test
