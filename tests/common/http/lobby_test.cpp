#include "common/http/lobby.h"

#include <vector>

#include <gmock/gmock.h>

namespace palpate {
namespace {

using testing::ElementsAre;

class LobbyTest : public testing::Test {
 protected:
  std::optional<Lobby::Id> Enter(const std::string& address, std::int64_t now_ns) {
    const int number = ++entered_;
    return lobby_.Enter(
        address, [this, number] { closed_.push_back(number); }, now_ns);
  }

  Lobby lobby_{3, 2};
  int entered_ = 0;
  std::vector<int> closed_;  // numbered in the order of entering, from 1
};

TEST_F(LobbyTest, LetsTheOneThatWaitedLongestMakeRoom) {
  const auto first = Enter("", 10);
  ASSERT_TRUE(first);
  EXPECT_TRUE(Enter("", 20));
  EXPECT_TRUE(Enter("", 30));
  EXPECT_THAT(closed_, ElementsAre());
  lobby_.Serve(*first);
  lobby_.Wait(*first, 40);  // it has been answered meanwhile
  EXPECT_TRUE(Enter("", 50));
  EXPECT_THAT(closed_, ElementsAre(2));
  EXPECT_TRUE(Enter("", 60));
  EXPECT_THAT(closed_, ElementsAre(2, 3));
  EXPECT_EQ(lobby_.size(), 3u);
}

TEST_F(LobbyTest, ClosesNobodyWhoIsBeingAnswered) {
  for (int i = 0; i < 3; ++i) lobby_.Serve(*Enter("", i));
  EXPECT_FALSE(Enter("", 10));
  EXPECT_THAT(closed_, ElementsAre());
  lobby_.Leave(1);
  EXPECT_TRUE(Enter("", 11));
}

TEST_F(LobbyTest, LeavesRoomForOthersWhereOneAddressTakesAllThatItMay) {
  const auto a = Enter("10.0.0.1", 1);
  const auto b = Enter("10.0.0.1", 2);
  EXPECT_TRUE(Enter("10.0.0.1", 3));
  EXPECT_THAT(closed_, ElementsAre(1)) << "its own make room";
  lobby_.Leave(*a);  // no effect: it is out already
  lobby_.Serve(*b);
  lobby_.Serve(3);
  EXPECT_FALSE(Enter("10.0.0.1", 4));
  EXPECT_TRUE(Enter("10.0.0.2", 5));
  EXPECT_THAT(closed_, ElementsAre(1));
}

TEST_F(LobbyTest, DoesNotBoundThisHostApart) {
  for (int i = 0; i < 3; ++i) lobby_.Serve(*Enter("", i));
  EXPECT_EQ(lobby_.size(), 3u);
}

}  // namespace
}  // namespace palpate
