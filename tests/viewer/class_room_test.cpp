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

}  // namespace
}  // namespace palpate::test
