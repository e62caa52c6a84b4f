// A course at the real palpate-viewer: who is made, renamed and withdrawn, and what is left of it
// when the gateway is killed.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <utility>

#include <gmock/gmock.h>

#include "client/viewer/topic_feed.h"
#include "tests/support/folder.h"
#include "tests/viewer/gateway.h"

namespace palpate::test {
namespace {

using CourseJson = nlohmann::json;

constexpr int kPolicyViolation = 1008;

std::string FirstLink(Gateway& gateway) {
  const std::string& said = gateway.program().Output();
  const std::size_t begin = said.find("#token=");
  if (begin == said.npos) return "";
  return said.substr(begin + 7, said.find('\n', begin) - begin - 7);
}

/// A page of a person's.
class Pupil {
 public:
  Pupil(Gateway& gateway, const std::string& token)
      : client_(gateway.port(), kV1, "", 0, {{"Authorization", "Bearer " + token}}) {
    client_.Subscribe(1, TopicFeed::kMe);
  }
  WebClient& client() { return client_; }
  /// What it hears of itself next.
  CourseJson Me() { return Read(1); }
  /// And of an exam.
  CourseJson Exam() {
    if (!std::exchange(hears_exam_, true)) client_.Subscribe(4, TopicFeed::kExam);
    return Read(4);
  }

 protected:
  CourseJson Read(std::uint32_t subscription) {
    const auto message = client_.Next(subscription);
    if (!message) return {};
    return CourseJson::parse(message->payload.begin(), message->payload.end());
  }
  WebClient client_;
  bool hears_exam_ = false;
};

class Teacher : public Pupil {
 public:
  Teacher(Gateway& gateway, const std::string& token) : Pupil(gateway, token) {
    client_.Subscribe(2, TopicFeed::kClassAnswer);
  }
  CourseJson Ask(CourseJson wish) {
    wish["tag"] = ++tag_;
    client_.SendClass(wish);
    CourseJson answer = Read(2);
    EXPECT_EQ(answer["tag"], tag_);
    return answer;
  }
  std::string Make(const std::string& name) {
    return Ask({{"op", "person_make"}, {"names", {name}}, {"role", "drive"}})["people"][0]["token"];
  }

 private:
  int tag_ = 0;
};

TEST(Course, MakesRenamesAndWithdrawsPeopleWhileTheyAreThere) {
  const Folder folder;
  Gateway gateway({"--course", folder / "course"});
  Teacher teacher(gateway, FirstLink(gateway));
  ASSERT_TRUE(teacher.client().open());
  const std::string token = teacher.Make("Anna");
  EXPECT_THAT(
      teacher.Ask({{"op", "person_make"}, {"names", {"Ben", "anna"}}, {"role", "drive"}})["refusal"]
          .get<std::string>(),
      testing::HasSubstr("would be one station"));

  Pupil anna(gateway, token);
  const CourseJson me = anna.Me();
  EXPECT_EQ(me["name"], "Anna");
  anna.client().SendClass({{"tag", 1}, {"op", "person_withdraw"}, {"person", 1}});
  EXPECT_THAT(anna.client().NextStatus(), testing::HasSubstr("is of no use here"));

  // Who publishes on what was not advertised to it has broken the protocol.
  EXPECT_EQ(anna.client().closed(), kPolicyViolation);
  Pupil again(gateway, token);
  EXPECT_EQ(again.Me()["name"], "Anna");
  teacher.Ask({{"op", "person_rename"}, {"person", me["person"]}, {"name", "Anne"}});
  EXPECT_TRUE(Eventually([&] { return again.Me()["name"] == "Anne"; }));
  teacher.Ask({{"op", "say"}, {"person", 0}, {"text", "Gently"}});
  EXPECT_TRUE(Eventually([&] { return again.Me()["line"] == "Gently"; }));
  const std::string renewed =
      teacher.Ask({{"op", "person_link"}, {"person", me["person"]}})["people"][0]["token"];
  EXPECT_EQ(again.client().closed(), kPolicyViolation);
  Pupil renewed_page(gateway, renewed);
  EXPECT_EQ(renewed_page.Me()["name"], "Anne");
  teacher.Ask({{"op", "person_withdraw"}, {"person", me["person"]}});
  EXPECT_EQ(renewed_page.client().closed(), kPolicyViolation);
  EXPECT_EQ(Get(gateway.port(), "/healthz", {{"Authorization", "Bearer " + renewed}}).status, 401);
}

TEST(Course, IsThereWithAllThatWasAnsweredAfterTheGatewayWasKilled) {
  const Folder folder;
  std::string link;
  std::vector<std::string> tokens;
  {
    Gateway gateway({"--course", folder / "course"});
    link = FirstLink(gateway);
    Teacher teacher(gateway, link);
    for (int i = 0; i < 10; ++i) tokens.push_back(teacher.Make("student " + std::to_string(i)));
    gateway.program().Signal(SIGKILL);
    EXPECT_EQ(gateway.program().Exit(), -SIGKILL);
  }
  Gateway gateway({"--course", folder / "course"});
  EXPECT_EQ(FirstLink(gateway), "") << "there is a teacher already";
  tokens.push_back(link);
  for (const std::string& token : tokens) {
    EXPECT_EQ(Get(gateway.port(), "/healthz", {{"Authorization", "Bearer " + token}}).status, 200);
  }
}

TEST(Course, HoldsAnExamWithWhichTheNextGatewayGoesOnWhereOneWasKilled) {
  const Folder folder;
  std::filesystem::create_directory(folder / "course");
  std::ofstream(folder / "course/midterm.exam.json")
      << R"({"title": "Midterm", "time_s": 600, "tasks": [{"exercise": "light-force"}]})";
  std::string token;
  {
    Gateway gateway({"--course", folder / "course"});
    Teacher teacher(gateway, FirstLink(gateway));
    token = teacher.Make("Anna");
    Pupil anna(gateway, token);
    EXPECT_EQ(anna.Exam()["open"], nullptr);
    // To hold one is not for those who sit it.
    anna.client().SendExam({{"tag", 1}, {"op", "open"}, {"exam", "midterm"}});
    EXPECT_EQ(anna.client().closed(), kPolicyViolation);
    teacher.client().SendExam({{"tag", 1}, {"op", "open"}, {"exam", "midterm"}});
    Pupil again(gateway, token);
    EXPECT_TRUE(
        Eventually([&] { return again.Exam()["open"]["exercise"]["name"] == "light-force"; }));
    again.client().SendMouse({{"op", "take"}, {"scene", "cube"}});
    again.client().Subscribe(3, TopicFeed::kMouseState);
    const auto told = again.client().Next(3);
    ASSERT_TRUE(told);
    EXPECT_THAT(std::string(told->payload.begin(), told->payload.end()),
                testing::HasSubstr("an exam is open"));
    gateway.program().Signal(SIGKILL);
    EXPECT_EQ(gateway.program().Exit(), -SIGKILL);
  }
  Gateway gateway({"--course", folder / "course"});
  Pupil anna(gateway, token);
  EXPECT_EQ(anna.Exam()["open"]["name"], "midterm");
}

TEST(Course, GivesEachASeatAndKeepsOthersOut) {
  StandIn server(2);
  const Folder folder;
  Gateway gateway({"--course", folder / "course"});
  const std::string link = FirstLink(gateway);
  ASSERT_TRUE(gateway.KnowsScenes(3, {{"Authorization", "Bearer " + link}}));
  Teacher teacher(gateway, link);
  Pupil anna(gateway, teacher.Make("Anna"));
  EXPECT_EQ(teacher.Ask({{"op", "begin"}, {"scene", "cube"}})["refusal"], "");
  EXPECT_TRUE(Eventually([&] { return anna.Me()["seat"] == "cube-1"; }));
  anna.client().SendMouse({{"op", "take"}, {"scene", "cube-2"}});
  anna.client().Subscribe(3, TopicFeed::kMouseState);
  const auto told = anna.client().Next(3);
  ASSERT_TRUE(told);
  EXPECT_THAT(std::string(told->payload.begin(), told->payload.end()),
              testing::HasSubstr("your seat is 'cube-1'"));
  // Who comes later has the next; then there is none.
  Pupil ben(gateway, teacher.Make("Ben"));
  EXPECT_TRUE(Eventually([&] { return ben.Me()["seat"] == "cube-2"; }));
  teacher.Make("Cleo");
  EXPECT_THAT(teacher.Ask({{"op", "begin"}, {"scene", "cube"}})["note"].get<std::string>(),
              testing::HasSubstr("1 of 3 have no seat"));
  EXPECT_THAT(teacher.Ask({{"op", "begin"}, {"scene", "cube-1"}})["refusal"].get<std::string>(),
              testing::HasSubstr("--seats"));
}

}  // namespace
}  // namespace palpate::test
