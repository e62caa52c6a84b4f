#include "common/json/json_file.h"

#include <gmock/gmock.h>

#include "common/error.h"
#include "tests/support/complaint.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::HasSubstr;

/// What Parse or `read` says about `text`.
template <class Read>
std::string Complaint(const std::string& text, Read read) {
  return ComplaintOf([&] { read(JsonNode::Parse(text, "f.json")); });
}

TEST(JsonFile, NamesTheLineOfANumberThatEndsItsLine) {
  const std::string text = "{ // a comment\n  \"a\": 1,\n  \"b\": 2\n}\n";
  EXPECT_THAT(Complaint(text, [](const JsonNode& n) { n.At("b").Number(5, 6); }),
              HasSubstr("f.json:3: b: 2 is not allowed; give a number from 5 to 6"));
  EXPECT_THAT(Complaint(text, [](const JsonNode& n) { n.At("a").Number(5); }),
              HasSubstr("f.json:2: a: 1 is not allowed; give at least 5"));
}

TEST(JsonFile, MayBeginWithAMarkOfUtf8AndNamesAnotherEncoding) {
  EXPECT_EQ(JsonNode::Parse("\xEF\xBB\xBF{\"a\": 1}", "f.json").At("a").Number(), 1.0);
  using namespace std::string_literals;
  for (const std::string& text :
       {"\xFF\xFE{\0\"\0a\0"s, "\xFE\xFF\0{\0\"\0a"s, "{\0\"\0"s, "\0{\0\""s}) {
    EXPECT_THAT(Complaint(text, [](const JsonNode&) {}),
                testing::AllOf(HasSubstr("f.json: "), HasSubstr("UTF-16")));
  }
}

TEST(JsonFile, NamesThePathOfANestedField) {
  const std::string text = "{\"tools\": [\n{},\n{\"leaves\": \"many\"}]}";
  EXPECT_THAT(
      Complaint(text,
                [](const JsonNode& n) { n.At("tools").Items()[1].At("leaves").Integer(1, 9); }),
      HasSubstr("f.json:3: tools[1].leaves: is a string; give a number"));
}

TEST(JsonFile, TellsTheWordFalseFromAllElse) {
  const JsonNode list = JsonNode::Parse("[false, true, 0, \"false\", null, {}]", "f.json");
  const std::vector<JsonNode> items = list.Items();
  EXPECT_TRUE(items[0].IsFalse());
  for (std::size_t i = 1; i < items.size(); ++i) EXPECT_FALSE(items[i].IsFalse()) << i;
}

TEST(JsonFile, GuessesWhatAnUnknownFieldMeant) {
  EXPECT_THAT(Complaint("{\"laeves\": 3}",
                        [](const JsonNode& n) {
                          n.AllowOnly({"leaves", "t"});
                        }),
              HasSubstr("f.json:1: laeves: there is no such field; did you mean \"leaves\"?"));
  EXPECT_THAT(Complaint("{\"xyzzy\": 3}",
                        [](const JsonNode& n) {
                          n.AllowOnly({"leaves", "t"});
                        }),
              testing::Not(HasSubstr("did you mean")));
}

TEST(JsonFile, RefusesWhatIsNotJsonAndSaysWhere) {
  const auto nothing = [](const JsonNode&) {};
  EXPECT_THAT(Complaint("{\n\"a\": 1,\n\"b\" 2}", nothing),
              HasSubstr("f.json:3: this is not JSON"));
  EXPECT_THAT(Complaint("", nothing), HasSubstr("f.json:1: this is not JSON"));
  EXPECT_THAT(Complaint("{\"a\": 1} trailing", nothing), HasSubstr("this is not JSON"));
  EXPECT_THAT(Complaint("{\"a\": 1e999}", nothing), HasSubstr("this is not JSON"));
  EXPECT_THAT(Complaint("{\"a\": 1,\n\"a\": 2}", nothing),
              HasSubstr("f.json:2: a: is given twice"));
  EXPECT_THAT(Complaint(std::string(1000, '['), nothing), HasSubstr("nested too deep"));
}

TEST(JsonFile, ReadsAPoseInDegreesAndMillimetres) {
  const Pose pose = JsonNode::Parse(
                        "{\"position_mm\": [1, 2, 3], "
                        "\"rotation_deg\": {\"axis\": [0, 0, 2], \"angle\": 90}}",
                        "f.json")
                        .ReadPose();
  EXPECT_TRUE(pose.p.isApprox(Vec3(0.001, 0.002, 0.003), 1e-15));
  EXPECT_TRUE((pose.q * Vec3::UnitX()).isApprox(Vec3::UnitY(), 1e-15));
}

TEST(JsonFile, RefusesRotationsThatAreNone) {
  const auto read = [](const JsonNode& n) { n.ReadPose(); };
  EXPECT_THAT(Complaint("{\"quaternion_wxyz\": [1, 1, 0, 0]}", read),
              HasSubstr("give a unit quaternion"));
  EXPECT_THAT(Complaint("{\"quaternion_wxyz\": [1, 0, 0]}", read), HasSubstr("give four numbers"));
  EXPECT_THAT(Complaint("{\"rotation_deg\": {\"axis\": [0, 0, 0], \"angle\": 1}}", read),
              HasSubstr("rotation_deg.axis: has length 0"));
  EXPECT_THAT(Complaint("{\"rotation_deg\": {\"axis\": [0, 0, 1], \"angle\": 1e308}}", read),
              HasSubstr("rotation_deg.angle: 1e+308 is not allowed; give a number from"));
  EXPECT_THAT(Complaint("{\"position_mm\": [0, 1e300, 0]}", read),
              HasSubstr("position_mm[1]: 1e+300 is not allowed"));
  EXPECT_THAT(Complaint("{\"quaternion_wxyz\": [1, 0, 0, 0], "
                        "\"rotation_deg\": {\"axis\": [0, 0, 1], \"angle\": 1}}",
                        read),
              HasSubstr("given twice"));
}

TEST(JsonFile, SaysWhyAFileCannotBeRead) {
  EXPECT_THAT(ComplaintOf([] { JsonNode::Load("/nowhere/scene.json"); }),
              HasSubstr("/nowhere/scene.json: No such file"));
  EXPECT_THROW(JsonNode::Load("/"), Error);
}

TEST(JsonNode, TakesNoTextForANameThatNobodyCouldRead) {
  const std::string much(JsonNode::kMostText + 1, 'x');
  const auto name = [](const JsonNode& n) { n.At("name").String(); };
  EXPECT_THAT(Complaint("{\"name\": \"" + much + "\"}", name),
              testing::StrEq("f.json:1: name: has 4097 bytes; give 4096 at most"));
  EXPECT_THAT(Complaint("{\"" + much + "\": 1}", name),
              testing::StrEq("f.json:1: a field's name has 4097 bytes; fix it"));
}

TEST(JsonNode, HasABoundOnItsValuesThatItNames) {
  std::string text = "[0";
  for (int i = 0; i < 2'000'000; ++i) text += ",0";
  EXPECT_THAT(ComplaintOf([&] { JsonNode::Parse(text + "]", "long.json"); }),
              HasSubstr("long.json:1: has more than 2000000 values"));
}

TEST(JsonNode, FindsAKeyThatStandsTwiceAmongMany) {
  std::string text = "{";
  for (int i = 0; i < 200'000; ++i) text += "\"k" + std::to_string(i) + "\":0,\n";
  EXPECT_THAT(ComplaintOf([&] { JsonNode::Parse(text + "\"k7\":1}", "keys.json"); }),
              HasSubstr("keys.json:200001: k7: is given twice"));
}

}  // namespace
}  // namespace palpate
