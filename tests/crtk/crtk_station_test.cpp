#include "client/crtk/crtk_station.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate::test {
namespace {

using testing::HasSubstr;

TEST(RosNames, BeginWithNoDigit) {
  EXPECT_EQ(RosNamespace("hand"), "/hand");
  EXPECT_EQ(RosNamespace("7"), "/station_7");
}

TEST(RosNames, HaveNoTwoUnderscoresSideBySide) {
  for (const char* name : {"hand", "left_hand", "_hidden", "hand_", "7_", "a_b_c"}) {
    EXPECT_EQ(WhyNoRosName(name), "") << name;
  }
  for (const char* name : {"left__hand", "__", "a___b", "__hand", "hand__"}) {
    EXPECT_THAT(WhyNoRosName(name), HasSubstr("give the station an --id without it")) << name;
  }
}

}  // namespace
}  // namespace palpate::test
