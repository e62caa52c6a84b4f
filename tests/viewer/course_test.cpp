// A course at the real palpate-viewer: who is made, renamed and withdrawn, and what is left of it
// when the gateway is killed.
#include <csignal>
#include <filesystem>
#include <fstream>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/folder.h"
#include "tests/support/read_file.h"
#include "tests/viewer/course_pages.h"

namespace palpate::test {
namespace {

constexpr int kPolicyViolation = 1008;

TEST(Course, MakesRenamesAndWithdrawsPeopleWhileTheyAreThere) {
  const Folder folder;
  Gateway gateway({"--course", folder / "course"});
  Teacher teacher(gateway, FirstLink(gateway));
  ASSERT_TRUE(teacher.client().open());
  const std::string token = teacher.Make("Anna");
  EXPECT_THAT(
      teacher.Refusal({{"op", "person_make"}, {"names", {"Ben", "anna"}}, {"role", "drive"}}),
      testing::HasSubstr("looks like"));

  Pupil anna(gateway, token);
  const CourseJson me = anna.Me();
  EXPECT_EQ(me["name"], "Anna");
  anna.client().SendClass({{"tag", 1}, {"op", "person_withdraw"}, {"person", 1}});
  EXPECT_THAT(anna.client().NextStatus(), testing::HasSubstr("is of no use here"));

  // A client that publishes on a channel not advertised to it has broken the protocol.
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

/// Adds what a recorded and scored trial leaves behind.
void AddTrial(const std::string& course, int person, const std::string& exercise, int n) {
  const std::string folder = fmt::format("{}/trials/{}/{}/{}", course, person, exercise, n);
  std::filesystem::create_directories(folder);
  std::ofstream(folder + "/score.html") << "the page of " << person;
  std::ofstream(folder + ".mcap") << std::string(1'000'000, 'r');
  SQLite::Database(course + "/course.sqlite", SQLite::OPEN_READWRITE, 5000)
      .exec(fmt::format("INSERT INTO trials(person, exercise, n, begun_s, ended_s, whole, points) "
                        "VALUES({}, '{}', {}, 1, 2, 1, {})",
                        person, exercise, n, 10 * person));
}

TEST(Course, TellsHistoryToTeachersAndToEachTheirOwn) {
  const Folder folder;
  Gateway gateway({"--course", folder / "course"});
  Teacher teacher(gateway, FirstLink(gateway));
  const std::string anna = teacher.Make("Anna"), ben = teacher.Make("Ben");
  AddTrial(folder / "course", 2, "light-force", 1);
  AddTrial(folder / "course", 3, "light-force", 1);
  const auto get = [&](const std::string& token, const std::string& path) {
    return Get(gateway.port(), path, {{"Authorization", "Bearer " + token}});
  };
  EXPECT_EQ(Get(gateway.port(), "/history/2.json", {}).status, 401);
  for (const char* others : {"/history/3.json", "/history/3.csv", "/history/3.zip",
                             "/history/class.json", "/history/class.csv"}) {
    EXPECT_EQ(get(anna, others).status, 403) << others;
    EXPECT_EQ(get(ben, "/history/2.json").status, 403);
  }
  const CourseJson own = CourseJson::parse(get(anna, "/history/2.json").body);
  EXPECT_EQ(own["name"], "Anna");
  EXPECT_EQ(own["exercises"][0]["done"][0]["points"], 20.0);
  EXPECT_EQ(own["exercises"][0]["spread"].size(), 0u) << "two are too few to hide in";
  const std::string page = own["exercises"][0]["done"][0]["page"];
  EXPECT_EQ(Get(gateway.port(), "/score/" + page, {}).body, "the page of 2");

  const std::string link = teacher.token();
  const CourseJson all = CourseJson::parse(get(link, "/history/class.json").body);
  EXPECT_EQ(all["people"].size(), 2u);
  EXPECT_EQ(all["exercises"][0]["spread"][0]["people"], 2);
  const CourseJson bens = CourseJson::parse(get(link, "/history/3.json").body);
  const std::string bens_page = bens["exercises"][0]["done"][0]["page"];
  EXPECT_EQ(Get(gateway.port(), "/score/" + bens_page, {}).body, "the page of 3");
  EXPECT_NE(page, bens_page);
  Program csv(PALPATE_BIN_DIR "/palpate-viewer",
              {"--course", folder / "course", "--export-csv", folder / "class.csv"});
  EXPECT_EQ(csv.Exit(), 0) << "beside a gateway that runs";
  EXPECT_EQ(ReadWholeFile(folder / "class.csv"), get(link, "/history/class.csv").body);
  EXPECT_THAT(get(link, "/history/class.csv").body, testing::HasSubstr("\r\n3,Ben,light-force,1,"));
  const auto zip = get(anna, "/history/2.zip");
  EXPECT_THAT(zip.body, testing::StartsWith("PK"));
  EXPECT_GT(zip.body.size(), 1'000'000u) << "in more pieces than one";
  EXPECT_THAT(zip.body, testing::HasSubstr("the page of 2"));
  EXPECT_THAT(zip.body, testing::Not(testing::HasSubstr("the page of 3")));
  EXPECT_EQ(get(link, "/history/9.zip").status, 404);
  EXPECT_EQ(get(link, "/history/none").status, 404);
}

TEST(Course, DeletesAPersonWithAllThatTheyDid) {
  const Folder folder;
  Gateway gateway({"--course", folder / "course"});
  Teacher teacher(gateway, FirstLink(gateway));
  Pupil anna(gateway, teacher.Make("Anna"));
  AddTrial(folder / "course", 2, "light-force", 1);
  const std::string link = teacher.token();
  const auto history = [&] {
    return CourseJson::parse(
        Get(gateway.port(), "/history/class.json", {{"Authorization", "Bearer " + link}}).body);
  };
  EXPECT_EQ(history()["people"].size(), 1u);
  EXPECT_THAT(teacher.Refusal({{"op", "person_delete"}, {"person", 1}}),
              testing::HasSubstr("is the last person with the role"));
  EXPECT_EQ(teacher.Refusal({{"op", "person_delete"}, {"person", 2}}), "");
  EXPECT_EQ(anna.client().closed(), kPolicyViolation);
  EXPECT_EQ(history()["people"].size(), 0u);
  EXPECT_FALSE(std::filesystem::exists(folder / "course/trials/2"));
  EXPECT_THAT(teacher.Refusal({{"op", "person_delete"}, {"person", 2}}),
              testing::HasSubstr("no person of this course"));
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
    // Those who sit an exam may not hold one.
    anna.client().SendExam({{"tag", 1}, {"op", "open"}, {"exam", "midterm"}});
    EXPECT_EQ(anna.client().closed(), kPolicyViolation);
    teacher.client().SendExam({{"tag", 1}, {"op", "open"}, {"exam", "midterm"}});
    Pupil again(gateway, token);
    EXPECT_TRUE(
        Eventually([&] { return again.Exam()["open"]["exercise"]["name"] == "light-force"; }));
    EXPECT_THAT(again.Take("cube"), testing::HasSubstr("an exam is open"));
    gateway.program().Signal(SIGKILL);
    EXPECT_EQ(gateway.program().Exit(), -SIGKILL);
  }
  Gateway gateway({"--course", folder / "course"});
  Pupil anna(gateway, token);
  EXPECT_EQ(anna.Exam()["open"]["name"], "midterm");
}

TEST(Course, IsKeptByOneGatewayAndTheSecondIsToldWhichOne) {
  const Folder folder;
  const std::vector<std::string> words = {
      "--http", "0", "--domain", std::to_string(kDomain), "--course", folder / "course"};
  {
    Gateway gateway({"--course", folder / "course"});
    Teacher teacher(gateway, FirstLink(gateway));
    teacher.Make("Anna");
    SQLite::Database(folder / "course/course.sqlite", SQLite::OPEN_READWRITE, 5000)
        .exec("INSERT INTO trials(person, exercise, n, begun_s) VALUES(2, 'light-force', 1, 1)");
    Program second(PALPATE_BIN_DIR "/palpate-viewer", words);
    EXPECT_EQ(second.Exit(), 1);
    const std::string& said = second.Output();
    EXPECT_THAT(said, testing::HasSubstr(folder / "course"));
    EXPECT_THAT(said, testing::HasSubstr(fmt::format("process {}", gateway.program().id())));
    EXPECT_THAT(said, testing::HasSubstr(fmt::format("127.0.0.1:{}/", gateway.port())));
    SQLite::Database course(folder / "course/course.sqlite", SQLite::OPEN_READONLY, 5000);
    EXPECT_EQ(course.execAndGet("SELECT COUNT(*) FROM trials WHERE ended_s IS NULL").getInt(), 1)
        << "what runs goes on";
    gateway.program().Signal(SIGKILL);
    EXPECT_EQ(gateway.program().Exit(), -SIGKILL);
  }
  Gateway next({"--course", folder / "course"});
  EXPECT_NE(next.port(), 0) << "a killed gateway keeps nothing";
}

TEST(Course, TouchesNoSceneWhereATrialMayNotBegin) {
  StandIn server(0, "calculus");
  const Folder folder;
  std::filesystem::create_directory(folder / "course");
  std::ofstream(folder / "course/midterm.exam.json")
      << R"({"title": "Midterm", "time_s": 600, "tasks": [{"exercise": "light-force"}]})";
  Gateway gateway({"--course", folder / "course"});
  const std::string link = FirstLink(gateway);
  ASSERT_TRUE(gateway.KnowsScenes(1, {{"Authorization", "Bearer " + link}}));
  Teacher teacher(gateway, link);
  Pupil anna(gateway, teacher.Make("Anna"));
  anna.client().SendTrial(
      {{"op", "begin"}, {"exercise", "supragingival-calculus"}, {"tool", "bur"}});
  EXPECT_THAT(anna.client().NextStatus(), testing::HasSubstr("choose one of: scaler"));
  teacher.client().SendExam({{"tag", 1}, {"op", "open"}, {"exam", "midterm"}});
  ASSERT_TRUE(Eventually([&] { return anna.Exam()["open"].is_object(); }));
  anna.client().SendTrial({{"op", "begin"}, {"exercise", "supragingival-calculus"}});
  EXPECT_THAT(anna.client().NextStatus(), testing::HasSubstr("not the exam's next task"));
  teacher.client().SendMouse({{"op", "whole"}, {"scene", "calculus"}});
  const auto wish = server.Wished();
  ASSERT_TRUE(wish);
  EXPECT_THAT(std::string(wish->by), testing::StartsWith("teacher")) << "and not Anna's";
}

/// A course whose pupil Anna begins a trial in the scene 'calculus'.
struct CalculusTrial {
  StandIn server{0, "calculus"};
  Folder folder{};
  Gateway gateway{{"--course", folder / "course"}};
  std::string link = FirstLink(gateway);
  bool knows = gateway.KnowsScenes(1, {{"Authorization", "Bearer " + link}});
  Teacher teacher{gateway, link};
  Pupil anna{gateway, teacher.Make("Anna")};

  CalculusTrial() {
    EXPECT_TRUE(knows);
    anna.client().SendTrial({{"op", "begin"}, {"exercise", "supragingival-calculus"}});
  }
};

TEST(Course, LetsNobodyRestoreASceneWhileATrialRunsThere) {
  CalculusTrial trial;
  auto& [server, folder, gateway, link, knows, teacher, anna] = trial;
  ASSERT_TRUE(anna.Comes({"preparing"}));
  ASSERT_TRUE(server.Wished()) << "the trial's own, before it begins";
  for (const char* const op : {"whole", "bookmark", "back"}) {
    anna.client().SendMouse({{"op", op}, {"scene", "calculus"}});
    EXPECT_THAT(anna.client().NextStatus(), testing::HasSubstr("trial")) << op;
  }
  teacher.client().SendMouse({{"op", "whole"}, {"scene", "calculus"}});
  EXPECT_THAT(teacher.client().NextStatus(), testing::HasSubstr("trial"));
  Pupil ben(gateway, teacher.Make("Ben"));
  EXPECT_THAT(ben.Take("calculus"), testing::HasSubstr("a trial runs in scene"))
      << "a scene may have further tools that cut";
  anna.client().SendTrial({{"op", "stop"}});
  ASSERT_TRUE(anna.Comes({"waiting", "scoring", "scored", "unscored"}));
  teacher.client().SendMouse({{"op", "whole"}, {"scene", "calculus"}});
  const auto wish = server.Wished();
  ASSERT_TRUE(wish);
  EXPECT_THAT(std::string(wish->by), testing::StartsWith("teacher")) << "and none before";
}

TEST(Course, EndsATrialWhoseSceneIsRestoredPastTheGateway) {
  CalculusTrial trial;
  auto& [server, folder, gateway, link, knows, teacher, anna] = trial;
  ASSERT_TRUE(anna.Comes({"preparing"}));
  server.TellWhole("calculus", "lesson on another host");
  CourseJson ended;
  ASSERT_TRUE(Eventually([&] {
    ended = anna.Trial();  // the newest only: that it ends may be overtaken by its scoring
    return ended.is_object() && ended["phase"] != "preparing" && ended["phase"] != "running";
  }));
  EXPECT_THAT(ended["reason"].get<std::string>(), testing::HasSubstr("lesson on another host"));
  EXPECT_EQ(ended["whole"], false);
}

TEST(Course, GivesEachASeatAndKeepsOthersOut) {
  StandIn server(2);
  const Folder folder;
  Gateway gateway({"--course", folder / "course"});
  const std::string link = FirstLink(gateway);
  ASSERT_TRUE(gateway.KnowsScenes(3, {{"Authorization", "Bearer " + link}}));
  Teacher teacher(gateway, link);
  Pupil anna(gateway, teacher.Make("Anna"));
  EXPECT_EQ(teacher.Refusal({{"op", "begin"}, {"scene", "cube"}}), "");
  EXPECT_TRUE(Eventually([&] { return anna.Me()["seat"] == "cube-1"; }));
  EXPECT_THAT(anna.Take("cube-2"), testing::HasSubstr("your seat is 'cube-1'"));
  // A later person gets the next seat, until there is none.
  Pupil ben(gateway, teacher.Make("Ben"));
  EXPECT_TRUE(Eventually([&] { return ben.Me()["seat"] == "cube-2"; }));
  Pupil cleo(gateway, teacher.Make("Cleo"));
  EXPECT_THAT(teacher.Ask({{"op", "begin"}, {"scene", "cube"}})["note"].get<std::string>(),
              testing::HasSubstr("1 of 3 have no seat"));
  EXPECT_THAT(teacher.Refusal({{"op", "begin"}, {"scene", "cube-1"}}),
              testing::HasSubstr("--seats"));
  // A person without a seat may not take another's, and nobody makes another's scene whole.
  EXPECT_THAT(cleo.Take("cube-1"), testing::HasSubstr("is the seat of another person"));
  anna.client().SendMouse({{"op", "whole"}, {"scene", "cube-2"}});
  EXPECT_THAT(anna.client().NextStatus(), testing::HasSubstr("your seat is 'cube-1'"));
}

}  // namespace
}  // namespace palpate::test
