#include "client/viewer/class_room.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/support/folder.h"

namespace palpate::test {
namespace {

TEST(ClassRoom, DeletesNobodyWhileATrialOfTheirsRuns) {
  const Folder folder;
  ClassRoom room(folder / "course");
  room.MakeFirstTeacher();
  room.roster().Make({"Anna"}, Access::kDrive);
  const auto remove = [&](bool is_busy) {
    const std::string answer = room.Do(
        ParseClassCommand(R"({"tag": 1, "op": "person_delete", "person": 2})"), Tokens(), {},
        [](std::int64_t) { return 1; }, [&](std::int64_t) { return is_busy; });
    return nlohmann::json::parse(answer)["refusal"].get<std::string>();
  };
  EXPECT_THAT(remove(true), testing::HasSubstr("a trial of 'Anna' is running"));
  EXPECT_NE(room.roster().Find(2), nullptr);
  room.roster().Withdraw(2);
  EXPECT_EQ(remove(false), "") << "who is withdrawn is deleted, too";
  EXPECT_EQ(room.roster().people().size(), 1u);
}

TEST(ClassRoom, TellsNamesAndTitlesBesideStationsAndFiles) {
  const Folder folder;
  ClassRoom room(folder / "course");
  room.roster().Make({"王伟"}, Access::kDrive);
  Exercise exercise;
  exercise.name = "light-force";
  exercise.title = {{"de", "Leichte Kraft"}};
  TrialRoom::News news;
  news.exercise = exercise.name;
  const auto json = nlohmann::json::parse(
      room.PeopleJson([](std::int64_t) { return 1; }, {{1, news}}, {exercise}, "mouse_"));
  EXPECT_EQ(json["people"][0]["name"], "王伟");
  EXPECT_EQ(json["people"][0]["station"], "mouse_wang_wei");
  EXPECT_EQ(json["people"][0]["trial"]["title"]["de"], "Leichte Kraft");
  const auto own = nlohmann::json::parse(room.OwnJson(1, {{"mouse_wang_wei", "王伟"}}));
  EXPECT_EQ(own["names"]["mouse_wang_wei"], "王伟");
}

TEST(ClassRoom, AddsNobodyWhoLooksLikeATokensHolder) {
  const Folder folder;
  ClassRoom room(folder / "course");
  Tokens others;
  others.Add({Access::kWatch, "Anna-B", {}, 0, "Anna_B"});
  const auto make = [&](const std::string& name) {
    const nlohmann::json wish = {
        {"tag", 1}, {"op", "person_make"}, {"names", {name}}, {"role", "drive"}};
    const std::string answer = room.Do(
        ParseClassCommand(wish.dump()), others, {}, [](std::int64_t) { return 0; },
        [](std::int64_t) { return false; });
    return nlohmann::json::parse(answer)["refusal"].get<std::string>();
  };
  EXPECT_THAT(make("\u0410nna-b"), testing::HasSubstr("'Anna-B'"));
  EXPECT_EQ(make("Anna B"), "") << "has another look, and gets another station";
  EXPECT_EQ(room.With(others).size(), 2u);
}

}  // namespace
}  // namespace palpate::test
