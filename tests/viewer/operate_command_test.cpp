#include "client/viewer/operate_command.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(OperateCommand, IsAWishForAStation) {
  for (const wire::OperateWish wish : {palpate_OPERATE_ADMIT, palpate_OPERATE_TAKE_BACK,
                                       palpate_OPERATE_MUTE, palpate_OPERATE_UNMUTE}) {
    std::string wrong;
    const auto command = ParseOperateCommand(
        std::string(R"({"op": ")") + OperateWishName(wish) + R"(", "station": "left_2"})", wrong);
    ASSERT_TRUE(command) << wrong;
    EXPECT_EQ(command->wish, wish);
    EXPECT_EQ(command->station, "left_2");
  }
}

TEST(OperateCommand, IsAGoalOfAScene) {
  std::string wrong;
  const auto command = ParseOperateCommand(
      R"({"op": "goal", "scene": "cube", "text": "Press gently", "limit_N": 0.5})", wrong);
  ASSERT_TRUE(command) << wrong;
  ASSERT_TRUE(command->goal);
  EXPECT_EQ(command->goal->scene, "cube");
  EXPECT_EQ(command->goal->text, "Press gently");
  EXPECT_EQ(command->goal->limit, 0.5);
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
    std::string wrong;
    EXPECT_FALSE(ParseOperateCommand(text, wrong)) << text;
    EXPECT_NE(wrong, "") << text;
  }
  std::string wrong;
  EXPECT_FALSE(ParseOperateCommand(
      R"({"op": "goal", "scene": "s", "limit_N": 0, "text": ")" + std::string(481, 'x') + R"("})",
      wrong));
}

}  // namespace
}  // namespace palpate
