#include "client/viewer/viewer_places.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr std::int64_t kLater = ViewerPlaces::kIdle_ns + 1;

class ViewerPlacesTest : public testing::Test {
 protected:
  /// Comes, makes the viewer that has to leave go, and subscribes.  False: it is turned away.
  bool Come(const std::string& address, std::int64_t now_ns = 0, bool subscribes = true) {
    const ViewerPlaces::Room room = places_.RoomFor(address, now_ns);
    if (room.leaves) {
      places_.Leave(*room.leaves);
      left_.push_back(*room.leaves);
    }
    if (!room.is_there) return false;
    places_.Enter(++last_, address, now_ns);
    if (subscribes) places_.Subscribed(last_);
    return true;
  }
  /// How many of `times` tries succeed.
  int ComeOften(const std::string& address, int times) {
    int came = 0;
    for (int i = 0; i < times; ++i) came += Come(address) ? 1 : 0;
    return came;
  }

  ViewerPlaces places_{10};
  ViewerPlaces::Id last_ = 0;
  std::vector<ViewerPlaces::Id> left_;
};

TEST_F(ViewerPlacesTest, AreAllForOneAddressWhileNobodyElseWantsThem) {
  EXPECT_EQ(ComeOften("class", 15), 10);
  EXPECT_EQ(places_.size(), 10u);
  EXPECT_TRUE(left_.empty());
}

TEST_F(ViewerPlacesTest, AreSharedWithOneWhoFloodsThemByEachAddressThatHasFewer) {
  EXPECT_EQ(ComeOften("flood", 300), 10);
  for (const char* address : {"a", "b"}) EXPECT_TRUE(Come(address)) << address;
  EXPECT_EQ(ComeOften("class", 29), 4) << "as many as it has left the flood";
  EXPECT_EQ(ComeOften("flood", 300), 0) << "and it does not get them back";
  EXPECT_EQ(places_.size(), 10u);
}

TEST_F(ViewerPlacesTest, AreMadeByThoseWhoCameLastAndHoldNoTool) {
  ComeOften("class", 10);
  places_.Holds(10, true);
  EXPECT_TRUE(Come("teacher"));
  EXPECT_EQ(left_, (std::vector<ViewerPlaces::Id>{9}));
  places_.Holds(10, false);
  EXPECT_TRUE(Come("other"));
  EXPECT_EQ(left_.back(), 10u);
  for (ViewerPlaces::Id id = 1; id <= 8; ++id) places_.Holds(id, true);  // all that the class has
  EXPECT_TRUE(Come("third"));
  EXPECT_EQ(left_.back(), 8u);
}

TEST_F(ViewerPlacesTest, AreMadeFirstByThoseWhoOnlySitThereWhoseverTheyAre) {
  EXPECT_TRUE(Come("a", 0, false));
  EXPECT_TRUE(Come("b", 1, false));
  for (int i = 0; i < 8; ++i) EXPECT_TRUE(Come("class", 2));
  EXPECT_FALSE(Come("class", 3)) << "they have just come";
  EXPECT_TRUE(Come("class", kLater));
  EXPECT_EQ(left_, (std::vector<ViewerPlaces::Id>{1})) << "the one that sat longest";
  EXPECT_TRUE(Come("class", kLater + 2));
  EXPECT_EQ(left_.back(), 2u);
  EXPECT_FALSE(Come("class", kLater + 3));
}

TEST_F(ViewerPlacesTest, AreFreeAgainOnceAViewerHasLeft) {
  ComeOften("class", 10);
  places_.Leave(4);
  places_.Leave(4);
  EXPECT_TRUE(Come("class"));
  EXPECT_FALSE(Come("class"));
}

}  // namespace
}  // namespace palpate
