#include "client/course/exam_turns.h"

#include <memory>

#include <gmock/gmock.h>

#include "tests/support/folder.h"

namespace palpate::test {
namespace {

using testing::ElementsAre;

TEST(ExamOrder, LetsNeighboursBeginAtDifferentScenesAndKeepsAScenesTasksTogether) {
  const std::vector<std::string> scenes = {"crown", "caries", "crown", "periodontal"};
  EXPECT_THAT(ExamTurns::OrderOf(5, false, scenes), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(ExamTurns::OrderOf(0, true, scenes), ElementsAre(0, 2, 1, 3));
  EXPECT_THAT(ExamTurns::OrderOf(1, true, scenes), ElementsAre(1, 3, 0, 2));
  EXPECT_THAT(ExamTurns::OrderOf(2, true, scenes), ElementsAre(3, 0, 2, 1));
  EXPECT_THAT(ExamTurns::OrderOf(3, true, scenes), ElementsAre(0, 2, 1, 3));
}

/// Candidates 1 to 4, of whom 4 is at another scene, and the seats that are free.
class ExamTurnsTest : public testing::Test {
 protected:
  void SetUp() override {
    for (const int person : {1, 2, 3, 4}) table_.Keep(7, {person, {1, 0}});
    Start();
  }
  /// Starts, or starts again as after a kill.
  void Start() {
    turns_ = std::make_unique<ExamTurns>(table_);
    turns_->Read(7, {1, 2, 3, 4}, 2);
  }
  static std::string SceneOf(std::int64_t person) { return person == 4 ? "caries" : "crown"; }
  bool Call() {
    return turns_->Call(now_s_,
                        {[this](std::int64_t, const std::string& scene) {
                           std::vector<std::string> seats;
                           for (const std::string& seat : free_) {
                             if (seat.starts_with(scene)) seats.push_back(seat);
                           }
                           return seats;
                         },
                         [this](std::int64_t person) { return !away_.contains(person); }},
                        SceneOf);
  }
  std::string SeatOf(std::int64_t person) { return turns_->Of(person).seat; }
  void Begin(std::int64_t person) {
    free_.erase(SeatOf(person));
    turns_->Begin(person);
    turns_->Begun(person);
  }

  const Folder folder_;
  CourseFile file_{folder_.path()};
  ExamTable table_{file_};
  std::unique_ptr<ExamTurns> turns_;
  std::set<std::string> free_;
  std::set<std::int64_t> away_;
  std::int64_t now_s_ = 1'800'000'000;
};

TEST_F(ExamTurnsTest, GivesASeatToWhoHasWaitedLongestForItsScene) {
  for (const int person : {3, 1, 2, 4}) turns_->Ask(person, now_s_);
  turns_->Ask(3, now_s_ + 5);  // once more: the place stays
  EXPECT_FALSE(Call());
  EXPECT_EQ(turns_->AheadOf(2, SceneOf), 2);
  EXPECT_EQ(turns_->AheadOf(4, SceneOf), 0) << "who waits for another scene is not ahead";
  free_ = {"crown-1", "crown-2"};
  EXPECT_TRUE(Call());
  EXPECT_EQ(SeatOf(3), "crown-1");
  EXPECT_EQ(SeatOf(1), "crown-2");
  EXPECT_EQ(SeatOf(2) + SeatOf(4), "");
  EXPECT_TRUE(turns_->IsKept("crown-1"));
  EXPECT_FALSE(turns_->IsKept("crown-3"));
  Begin(3);
  EXPECT_FALSE(turns_->IsKept("crown-1"));
  free_.insert("caries");
  EXPECT_TRUE(Call());
  EXPECT_EQ(SeatOf(4), "caries") << "though another came before";
  EXPECT_EQ(SeatOf(2), "");
}

TEST_F(ExamTurnsTest, CountsTheTimeOfWaitingAndNotThatOfASeatThatIsKept) {
  turns_->Ask(1, now_s_);
  now_s_ += 40;
  EXPECT_EQ(turns_->Of(1).WaitsFor_s(now_s_), 40);
  free_ = {"crown"};
  Call();
  now_s_ += 20;
  EXPECT_EQ(turns_->Of(1).WaitsFor_s(now_s_), 0);
  EXPECT_EQ(turns_->Of(1).waited_s, 40);
  free_.clear();  // somebody from elsewhere has taken it
  EXPECT_TRUE(Call());
  now_s_ += 10;
  EXPECT_EQ(turns_->Of(1).WaitsFor_s(now_s_), 10);
  turns_->Move(3600);
  EXPECT_EQ(turns_->Of(1).WaitsFor_s(now_s_ + 3600), 10) << "the clock was set";
}

TEST_F(ExamTurnsTest, GivesTheSeatToTheNextOneWhereTheFirstDoesNotBegin) {
  for (const int person : {1, 2}) turns_->Ask(person, now_s_);
  free_ = {"crown"};
  Call();
  now_s_ += ExamTurns::kCalled_s - 1;
  EXPECT_FALSE(Call());
  now_s_ += 1;
  EXPECT_TRUE(Call());
  EXPECT_EQ(turns_->Of(1).place, 0);
  EXPECT_EQ(SeatOf(2), "crown");
  turns_->Ask(1, now_s_);
  EXPECT_GT(turns_->Of(1).place, turns_->Of(2).place);
}

TEST_F(ExamTurnsTest, PassesOverWhoIsAwayAndForgetsThemAfterHalfAMinute) {
  for (const int person : {1, 2}) turns_->Ask(person, now_s_);
  Call();
  away_ = {1, 2};
  free_ = {"crown"};
  now_s_ += ExamTurns::kAway_s;
  EXPECT_FALSE(Call()) << "nobody is there who could begin";
  away_ = {2};
  EXPECT_TRUE(Call());
  EXPECT_EQ(SeatOf(1), "crown") << "who came back in time";
  EXPECT_EQ(turns_->Of(2).place, 2);
  now_s_ += 1;
  EXPECT_TRUE(Call());
  EXPECT_EQ(turns_->Of(2).place, 0) << "whose clock goes on again";
  EXPECT_EQ(turns_->Of(2).waited_s, ExamTurns::kAway_s + 1);
}

TEST_F(ExamTurnsTest, AreTheSameAfterTheGatewayWasKilled) {
  for (const int person : {2, 3, 1}) turns_->Ask(person, now_s_);
  free_ = {"crown"};
  Call();
  Begin(2);
  free_ = {"crown-2"};
  now_s_ += 30;
  Call();
  EXPECT_EQ(SeatOf(3), "crown-2");
  Start();
  EXPECT_THAT(turns_->Of(1).tasks, ElementsAre(1, 0));
  EXPECT_EQ(turns_->Of(2).place, 0);
  EXPECT_EQ(turns_->Of(1).WaitsFor_s(now_s_), 30);
  EXPECT_EQ(turns_->Of(3).waited_s, 30);
  EXPECT_TRUE(Call());
  EXPECT_EQ(SeatOf(3), "crown-2") << "the first is still the first";
  EXPECT_EQ(SeatOf(1), "");
}

}  // namespace
}  // namespace palpate::test
