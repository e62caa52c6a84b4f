#include "client/viewer/page_messages.h"

#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/support/complaint.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

std::string Complaint(const std::string& text) {
  return test::ComplaintOf([&] { ParseReplayWish(text); });
}

/// A valid wish with one field replaced; null: without it.
std::string With(const std::string& field, const Json& value,
                 const std::string& wish = "add_bookmark") {
  Json json = {
      {"replay", "5f3a"}, {"tag", 1}, {"wish", wish}, {"value", 1.5}, {"text", "the slip"}};
  if (value.is_null()) {
    json.erase(field);
  } else {
    json[field] = value;
  }
  return json.dump();
}

TEST(MouseCommand, TakesDragsReleasesAndMakesWhole) {
  const MouseCommand take = ParseMouseCommand(R"({"op":"take","scene":"cube","tool":"ball"})");
  EXPECT_EQ(take.op, MouseCommand::Op::kTake);
  EXPECT_EQ(take.scene, "cube");
  EXPECT_EQ(take.tool, "ball");
  EXPECT_EQ(ParseMouseCommand(R"({"op":"take","scene":"cube"})").tool, "");
  const MouseCommand pose = ParseMouseCommand(R"({"op":"pose","p":[0.1,-2,3e-3],"q":[1,0,0.5,0]})");
  EXPECT_EQ(pose.op, MouseCommand::Op::kPose);
  EXPECT_EQ(pose.X_WT.p, Vec3(0.1, -2, 0.003));
  EXPECT_EQ(pose.X_WT.q.y(), 0.5);
  EXPECT_FALSE(pose.still);
  const char* const still = R"({"op":"pose","p":[0,0,0],"q":[1,0,0,0],"still":true})";
  EXPECT_TRUE(ParseMouseCommand(still).still);
  EXPECT_EQ(ParseMouseCommand(R"({"op":"release"})").op, MouseCommand::Op::kRelease);
  const MouseCommand whole = ParseMouseCommand(R"({"op":"whole","scene":"calculus"})");
  EXPECT_EQ(whole.op, MouseCommand::Op::kWhole);
  EXPECT_EQ(whole.scene, "calculus");
}

TEST(OperateCommand, IsAWishForAStationOrAGoalOfAScene) {
  for (const wire::OperateWish wish : {palpate_OPERATE_ADMIT, palpate_OPERATE_TAKE_BACK,
                                       palpate_OPERATE_MUTE, palpate_OPERATE_UNMUTE}) {
    const OperateCommand command = ParseOperateCommand(
        R"({"op": ")" + std::string(OperateWishName(wish)) + R"(", "station": "left_2"})");
    EXPECT_EQ(command.wish, wish);
    EXPECT_EQ(command.station, "left_2");
  }
  const OperateCommand goal = ParseOperateCommand(
      R"({"op": "goal", "scene": "cube", "text": "Press gently", "limit_N": 0.5})");
  ASSERT_TRUE(goal.goal);
  EXPECT_EQ(goal.goal->scene, "cube");
  EXPECT_EQ(goal.goal->text, "Press gently");
  EXPECT_EQ(goal.goal->limit, 0.5);
}

TEST(ReplayWish, IsReadWithAllThatItNeeds) {
  const ReplayWish play =
      ParseReplayWish(R"({"replay":"ffffffffffffffff","tag":4294967295,"wish":"play"})");
  EXPECT_EQ(play.request.replay, 0xffffffffffffffffu);
  EXPECT_EQ(play.tag, 4294967295u);
  EXPECT_EQ(play.request.wish, palpate_REPLAY_PLAY);
  const ReplayWish seek = ParseReplayWish(With("value", 12.5, "seek"));
  EXPECT_EQ(seek.request.wish, palpate_REPLAY_SEEK);
  EXPECT_EQ(seek.request.value, 12.5);
  EXPECT_EQ(ParseReplayWish(With("value", 2, "rate")).request.wish, palpate_REPLAY_RATE);
  EXPECT_EQ(ParseReplayWish(With("value", 2, "pause")).request.wish, palpate_REPLAY_PAUSE);
  EXPECT_EQ(ParseReplayWish(With("value", 3, "drop_bookmark")).request.wish,
            palpate_REPLAY_DROP_BOOKMARK);
  const ReplayWish bookmark = ParseReplayWish(With("value", 0));
  EXPECT_EQ(bookmark.request.wish, palpate_REPLAY_ADD_BOOKMARK);
  EXPECT_EQ(bookmark.request.kind, static_cast<std::uint32_t>(palpate_REPLAY_ADD_BOOKMARK));
  EXPECT_STREQ(bookmark.request.text, "the slip");
}

TEST(ReplayWish, IsRefusedForTheFieldThatIsWrong) {
  for (const Json& id :
       std::vector<Json>{nullptr, 5, "", "0", "00", "05f3a", "0x5f", "-1", "+1", " 5", "5 ", "5F",
                         "5g", "10000000000000000", "1ffffffffffffffff", std::string("5\0", 2),
                         Json::array({"5f3a"})}) {
    EXPECT_THAT(Complaint(With("replay", id)), HasSubstr(": replay"));
  }
  for (const Json& wish : std::vector<Json>{nullptr, "", "jump", "PLAY", "play ", 0, true}) {
    EXPECT_THAT(Complaint(With("wish", wish)), HasSubstr(": wish")) << wish;
  }
  EXPECT_THAT(Complaint(With("wish", "jump")), HasSubstr("give one of play, pause"));
  for (const Json& tag : std::vector<Json>{nullptr, "1", -1, 1.5, 4294967296}) {
    EXPECT_THAT(Complaint(With("tag", tag)), HasSubstr(": tag")) << tag;
  }
  for (const char* wish : {"seek", "rate", "add_bookmark", "drop_bookmark"}) {
    for (const Json& value : std::vector<Json>{nullptr, "1", true}) {
      EXPECT_THAT(Complaint(With("value", value, wish)), HasSubstr(": value")) << wish;
    }
  }
}

TEST(PageMessages, AreNothingElse) {
  const auto refuses = [](auto parse, const std::vector<std::string>& texts) {
    for (const std::string& text : texts) EXPECT_THROW(parse(text), Error) << text;
  };
  const std::string longest(64, 'x');
  EXPECT_EQ(ParseMouseCommand(R"({"op":"take","scene":")" + longest + R"("})").scene, longest);
  refuses(
      ParseMouseCommand,
      {"", "{", "[]", "{}", R"({"op":"jump"})", R"({"op":"take"})", R"({"op":"whole"})",
       R"({"op":"take","scene":3})", R"({"op":"take","scene":""})", R"({"op":"pose"})",
       R"({"op":"pose","p":[1,2],"q":[1,0,0,0]})", R"({"op":"pose","p":[1,2,"3"],"q":[1,0,0,0]})",
       R"({"op":"pose","p":[1,2,null],"q":[1,0,0,0]})",
       R"({"op":"pose","p":[1,2,1e999],"q":[1,0,0,0]})", R"({"op":"pose","p":[1,2,3],"q":[1,0,0]})",
       R"({"op":"take","scene":"x)" + longest + R"("})",
       R"({"op":"take","scene":"cube","tool":"x)" + longest + R"("})"});
  const std::string too_long(481, 'x');
  refuses(ParseOperateCommand,
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
           R"({"op": "mute", "station": "left"} {})",
           R"({"op": "mute", "station": "a23456789012345678901234567890123"})",
           R"({"op": "mute", "station": "left", "by": "me"})",
           "{\"op\": \"mute\", \"station\": \"\xff\"}",
           R"({"op": "goal", "scene": "cube", "text": "x"})",
           R"({"op": "goal", "scene": "cube", "text": "x", "limit_N": "1"})",
           R"({"op": "goal", "scene": "cube", "text": "x", "limit_N": -1})",
           R"({"op": "goal", "scene": "cube", "text": "x", "limit_N": 1e999})",
           R"({"op": "goal", "scene": "cube", "text": 7, "limit_N": 1})",
           R"({"op": "goal", "scene": "cube", "text": "x", "limit_N": 1, "station": "left"})"});
  refuses(ParseOperateCommand,
          {R"({"op": "goal", "scene": "s", "limit_N": 0, "text": ")" + too_long + "\"}"});
  std::vector<std::string> wishes = {"", "{", "[]", "{}", "3"};
  for (const char* value : {"1e999", "-1e999", "NaN", "Infinity", "null", "nan"}) {
    wishes.push_back(std::string(R"({"replay":"5","tag":1,"wish":"seek","value":)") + value + "}");
  }
  wishes.push_back(
      "{\"replay\":\"5\",\"tag\":1,\"wish\":\"add_bookmark\",\"value\":1,\"text\":\"caf\xe9\"}");
  refuses(ParseReplayWish, wishes);
}

TEST(ReplayWish, CountsATextsBytesAndNotItsLetters) {
  std::string letters;
  for (int i = 0; i < 60; ++i) letters += "é";
  EXPECT_EQ(ParseReplayWish(With("text", letters)).request.text, letters);
  EXPECT_THAT(Complaint(With("text", letters + "x")), HasSubstr("120 bytes"));
  for (const Json& text : std::vector<Json>{3, nullptr, std::string("a\0b", 3)}) {
    EXPECT_THAT(Complaint(With("text", text)), HasSubstr(": text")) << text;
  }
}

TEST(ReplayJson, TellsContentsWithNumbersThatJavaScriptHas) {
  wire::ReplayMark marks[2]{};
  marks[0] = {.at_s = 1.5, .number = 7, .kind = palpate_REPLAY_BOOKMARK, .text = {}};
  wire::FromText("the slip", marks[0].text);
  marks[1].kind = palpate_REPLAY_WHOLE;
  wire::ReplayGap gap{.from_s = 2, .to_s = 3, .station = "arm", .reason = "silent"};
  wire::ReplayContents contents{};
  contents.replay = 0xfedcba9876543210;
  wire::FromText("les\xe9on.mcap", contents.recording);
  contents.begun_ns = 1'700'000'000'250'000'000;
  contents.length_s = 60;
  contents.locked = true;
  contents.marks = {2, 2, marks, false};
  contents.gaps = {1, 1, &gap, false};
  const Json json = Json::parse(ToJson(contents));
  EXPECT_EQ(json["replay"], "fedcba9876543210");
  EXPECT_EQ(json["recording"], "les\xef\xbf\xbdon.mcap");
  EXPECT_NEAR(json["begun_s"].get<double>(), 1'700'000'000.25, 1e-6);
  EXPECT_EQ(json["length_s"], 60);
  EXPECT_EQ(json["locked"], true);
  EXPECT_EQ(json["marks"][0],
            Json({{"at_s", 1.5}, {"number", 7}, {"kind", "bookmark"}, {"text", "the slip"}}));
  EXPECT_EQ(json["marks"][1]["kind"], "whole");
  EXPECT_EQ(
      json["gaps"],
      Json::array({{{"from_s", 2.}, {"to_s", 3.}, {"station", "arm"}, {"reason", "silent"}}}));
  wire::ReplayContents empty{};
  empty.replay = 1;
  EXPECT_EQ(Json::parse(ToJson(empty))["marks"], Json::array());
}

TEST(ReplayJson, TellsTheStateAndTheAnswer) {
  wire::ReplayState state{};
  state.replay = 0x12;
  state.at_s = 3.25;
  state.rate = 0.5;
  state.sought = 1;
  state.playing = true;
  state.request = 0xffffffffffffffff;
  wire::FromText("no", state.refusal);
  EXPECT_EQ(Json::parse(ToJson(state)), Json({{"replay", "12"},
                                              {"at_s", 3.25},
                                              {"rate", 0.5},
                                              {"sought", 1.},
                                              {"playing", true},
                                              {"ended", false},
                                              {"request", "ffffffffffffffff"},
                                              {"refusal", "no"}}));
  EXPECT_EQ(Json::parse(ReplayAnswer(7, 0xab, "")),
            Json({{"tag", 7}, {"request", "ab"}, {"refusal", ""}}));
}

}  // namespace
}  // namespace palpate
