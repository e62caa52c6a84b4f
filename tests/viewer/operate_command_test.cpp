#include "client/viewer/operate_command.h"

#include <gtest/gtest.h>

#include "common/error.h"

namespace palpate {
namespace {

TEST(OperateCommand, IsAWishForAStation) {
  for (const wire::OperateWish wish : {palpate_OPERATE_ADMIT, palpate_OPERATE_TAKE_BACK,
                                       palpate_OPERATE_MUTE, palpate_OPERATE_UNMUTE}) {
    const OperateCommand command = ParseOperateCommand(
        R"({"op": ")" + std::string(OperateWishName(wish)) + R"(", "station": "left_2"})");
    EXPECT_EQ(command.wish, wish);
    EXPECT_EQ(command.station, "left_2");
  }
}

TEST(OperateCommand, IsAGoalOfAScene) {
  const OperateCommand command = ParseOperateCommand(
      R"({"op": "goal", "scene": "cube", "text": "Press gently", "limit_N": 0.5})");
  ASSERT_TRUE(command.goal);
  EXPECT_EQ(command.goal->scene, "cube");
  EXPECT_EQ(command.goal->text, "Press gently");
  EXPECT_EQ(command.goal->limit, 0.5);
}

TEST(OperateCommand, IsNothingElse) {
  for (const char* text :
       {"",
        "[]",
        "null",
        "{}",
        R"({"op": "mute"})",
        R"({"station": "left"})",
        R"({"op": "dance", "station": "left"})",
        R"({"op": "MUTE", "station": "left"})",
        R"({"op": 1, "station": "left"})",
        R"({"op": "mute", "station": 7})",
        R"({"op": "mute", "station": ""})",
        R"({"op": "mute", "station": "left/right"})",
        R"({"op": "mute", "station": "left\n"})",
        R"({"op": "mute", "station": "a23456789012345678901234567890123"})",
        R"({"op": "mute", "station": "left", "by": "me"})",
        R"({"op": "goal", "scene": "cube", "text": "x"})",
        R"({"op": "goal", "scene": "cube", "text": "x", "limit_N": "1"})",
        R"({"op": "goal", "scene": "cube", "text": "x", "limit_N": -1})",
        R"({"op": "goal", "scene": "cube", "text": "x", "limit_N": 1e999})",
        R"({"op": "goal", "scene": "cube", "text": 7, "limit_N": 1})",
        R"({"op": "goal", "scene": "cube", "text": "x", "limit_N": 1, "station": "left"})",
        R"({"op": "mute", "station": "left"} {})",
        "{\"op\": \"mute\", \"station\": \"\xff\"}"}) {
    EXPECT_THROW(ParseOperateCommand(text), Error) << text;
  }
  EXPECT_THROW(ParseOperateCommand(R"({"op": "goal", "scene": "s", "limit_N": 0, "text": ")" +
                                   std::string(481, 'x') + R"("})"),
               Error);
}

}  // namespace
}  // namespace palpate
