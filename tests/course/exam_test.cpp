#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "client/course/exam_clock.h"
#include "client/course/exam_room.h"
#include "common/files/whole_file.h"
#include "common/realtime/steady_clock.h"
#include "tests/support/complaint.h"
#include "tests/support/eventually.h"
#include "tests/support/folder.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;

/// Stand-ins under the recorder's and the replayer's names.
constexpr const char* kExamRecorder =
    "#!/bin/sh\nfor word; do case $word in --output=*) out=${word#--output=};; esac; done\n"
    "echo hand > $out; trap 'exit 0' INT\necho \"recording to $out\"\nwhile :; do sleep 0.01; "
    "done\n";
constexpr const char* kExamReplayer = R"(#!/bin/sh
for word; do case $word in --out=*) out=${word#--out=};; esac; done
mkdir -p $out && echo page > $out/score.html
echo '{"passed": true, "trials": [{"points": 81.5}]}' > $out/score.json
)";
/// What ComplaintOf returns where nothing is wrong.
constexpr const char* kGood = "no complaint";
constexpr const char* kExam = R"({"title": {"en": "Midterm"}, "time_s": 600, "tasks": [
  {"exercise": "light-force", "time_s": 60, "trials": 2}, {"exercise": "pocket-depth"}]})";

TEST(ExamFile, IsReadAndRefusedWithFileLineAndRemedy) {
  const Folder folder;
  const std::string file = folder / "midterm.exam.json";
  const auto complaint = [&](const std::string& text) {
    std::ofstream(file) << text;
    return ComplaintOf([&] { LoadExam(file); });
  };
  EXPECT_EQ(complaint(kExam), kGood);
  const Exam exam = LoadExam(file);
  EXPECT_EQ(exam.name, "midterm");
  EXPECT_EQ(exam.tasks.at(0).time_s, 60.0);
  EXPECT_EQ(exam.tasks.at(1).trials, 1);
  EXPECT_EQ(exam.tasks.at(1).exercise_sha256.size(), 64u);
  EXPECT_THAT(complaint(R"({"title": "A", "time_s": 60, "tasks": [{"exercise": "none"}]})"),
              HasSubstr("midterm.exam.json:1: tasks[0].exercise: there is no such exercise; put "));
  EXPECT_THAT(complaint(R"({"title": "A", "time_s": 60, "tasks": [], "hints": true})"),
              HasSubstr("hints"));
  // Longer than a file's name may be, and a link to nowhere.
  const auto of_task = [](const std::string& name) {
    return R"({"title": "A", "time_s": 60, "tasks": [{"exercise": ")" + name + "\"}]}";
  };
  EXPECT_THAT(complaint(of_task(std::string(300, 'a'))), HasSubstr("there is no such exercise"));
  std::filesystem::create_directory(folder / "exercises");
  std::filesystem::create_symlink("loop.exercise.json", folder / "exercises/loop.exercise.json");
  EXPECT_THAT(complaint(of_task("loop")), HasSubstr("there is no such exercise"));
  std::string many = R"({"title": "A", "time_s": 60, "tasks": [{"exercise": "light-force"})";
  for (int i = 0; i < 50; ++i) many += R"(, {"exercise": "none"})";
  EXPECT_THAT(complaint(many + "]}"), HasSubstr("more than 50")) << "before any is read";
  EXPECT_THAT(complaint(R"({"title": "A", "time_s": 1e6, "tasks": [{"exercise": "light-force"}]})"),
              HasSubstr("time_s"));
  EXPECT_THAT(complaint(R"({"title": "A", "time_s": 60, "people": ["A", "A"],
                            "tasks": [{"exercise": "light-force"}]})"),
              HasSubstr("people[1]: is listed twice"));
}

class ExamTest : public testing::Test {
 protected:
  void SetUp() override {
    SetProgram("palpate-record", kExamRecorder);
    SetProgram("palpate-replay", kExamReplayer);
    std::filesystem::create_directory(folder_ / "course");
    std::ofstream(folder_ / "course/midterm.exam.json") << kExam;
    Start();
    anna_ = roster_->Make({"Anna"}, Access::kDrive).front().person.id;
    roster_->Make({"teacher"}, Access::kOperate);
  }
  void SetProgram(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    std::filesystem::permissions(folder_ / name, std::filesystem::perms::owner_all);
  }
  /// Starts, or starts again as after a kill.
  void Start() {
    exams_.reset();
    trials_.reset();
    roster_.reset();
    file_.reset();
    file_ = std::make_unique<CourseFile>(folder_ / "course");
    roster_ = std::make_unique<Roster>(*file_);
    trials_ =
        std::make_unique<TrialRoom>(TrialRoom::Options{folder_ / "course", folder_.path(), {}},
                                    *file_, [this](const TrialRoom::News& news) {
                                      phase_ = news.phase;
                                      if (exams_ && news.phase != "preparing")
                                        exams_->ReadOf(news.person);
                                    });
    exams_ = std::make_unique<ExamRoom>(folder_ / "course", *file_, *roster_, *trials_, now_s_);
  }
  std::string Do(const std::string& op, Json wish = Json::object()) {
    wish["op"] = op;
    wish["tag"] = 1;
    return Json::parse(exams_->Do(wish.dump(), now_s_))["refusal"];
  }
  std::string Open() { return Do("open", {{"exam", "midterm"}}); }
  std::string Begin(const std::string& exercise) {
    return ComplaintOf([&] {
      exams_->Begin({7, anna_, exercise, "Anna", "periodontal", 0x5f3a}, now_s_,
                    SteadyNanoseconds());
    });
  }
  bool Comes(const std::function<bool()>& what) {
    return Eventually([&] {
      trials_->Poll(SteadyNanoseconds());
      exams_->Poll(now_s_);
      return what();
    });
  }
  /// Runs a trial to its end.
  void Try(const std::string& exercise) {
    ASSERT_EQ(Begin(exercise), kGood);
    ASSERT_TRUE(Comes([&] { return phase_ == "running"; }));
    trials_->End(7, "stopped");
    ASSERT_TRUE(Comes([&] { return phase_ == "kept"; }));
  }
  Json Own() { return Json::parse(exams_->StateJson(anna_, false, now_s_))["open"]; }
  Json Trials() {
    return Json::parse(exams_->StateJson(0, true, now_s_))["open"]["people"][0]["trials"];
  }

  const Folder folder_;
  std::unique_ptr<CourseFile> file_;
  std::unique_ptr<Roster> roster_;
  std::unique_ptr<TrialRoom> trials_;
  std::unique_ptr<ExamRoom> exams_;
  std::string phase_;
  std::int64_t anna_ = 0, now_s_ = 1'800'000'000;
};

TEST_F(ExamTest, FindsItsPeopleHoweverTheirNamesAreWrittenAndNamesTheNearest) {
  const std::int64_t zoe = roster_->Make({"Zoë Kowalski"}, Access::kDrive).front().person.id;
  const auto open_for = [&](const std::string& name) {
    std::ofstream(folder_ / "course/midterm.exam.json")
        << R"({"title": "A", "time_s": 60, "tasks": [{"exercise": "light-force"}], "people": [")" +
               name + "\"]}";
    return Open();
  };
  EXPECT_THAT(open_for("Zoe Kowalsky"), HasSubstr("'Zoë Kowalski'"));
  EXPECT_THAT(open_for("Teacher"), HasSubstr("'teacher'")) << "who does not drive";
  EXPECT_EQ(open_for("\ufeff ZOE\u0308  Kowalski"), "");
  EXPECT_TRUE(exams_->Sits(zoe));
  EXPECT_FALSE(exams_->Sits(anna_));
}

TEST_F(ExamTest, GivesItsTasksInOrderWithoutScoreAndSealsWhatIsHandedIn) {
  EXPECT_FALSE(exams_->Sits(anna_));
  ASSERT_EQ(Open(), "");
  EXPECT_TRUE(exams_->Sits(anna_));
  EXPECT_THAT(Open(), HasSubstr("is open; close it first"));
  EXPECT_EQ(Own()["exercise"]["name"], "light-force");
  EXPECT_EQ(Own()["left_s"], 600);
  EXPECT_THAT(Begin("pocket-depth"), HasSubstr("not the exam's next task"));
  Try("light-force");
  EXPECT_EQ(Own()["trial"], 2);
  Try("light-force");
  EXPECT_EQ(Own()["task"], 1);
  EXPECT_THAT(Begin("light-force"), HasSubstr("not the exam's next task"));
  Try("pocket-depth");
  EXPECT_EQ(Own()["task"], 2);
  EXPECT_THAT(Begin("pocket-depth"), HasSubstr("all of the exam's tasks"));
  ASSERT_TRUE(Comes([&] { return Trials()[2]["sealed"] == true; }));
  EXPECT_TRUE(Trials()[0]["points"].is_null());

  const std::string stem = folder_ / fmt::format("course/trials/{}/light-force/1", anna_);
  const SealKey key = SealKey::ReadPublic(folder_ / "course/exam-key.pub.pem");
  const Seal seal = OpenSeal(ReadWholeFile(stem + ".seal.json", kLargestSeal), key, "it");
  EXPECT_EQ(seal.sha256, Sha256("hand\n"));
  EXPECT_EQ(seal.name, "Anna");
  EXPECT_EQ(seal.scene_hash, "0000000000005f3a");
  EXPECT_EQ(seal.reason, "stopped");

  ASSERT_EQ(Do("close"), "");
  EXPECT_FALSE(exams_->Sits(anna_));
  ASSERT_TRUE(Comes([&] { return Trials()[2]["points"] == 81.5; }));
  const Roll roll = OpenRoll(
      ReadWholeFile(folder_ / "course/exams/midterm-1.roll.json", kLargestSeal), key, "it");
  EXPECT_EQ(roll.trials.size(), 3u);
  EXPECT_EQ(roll.trials[0].sha256, seal.sha256);
}

TEST_F(ExamTest, GoesOnWhereItWasAfterTheGatewayWasKilled) {
  ASSERT_EQ(Open(), "");
  Try("light-force");
  ASSERT_EQ(Begin("light-force"), kGood);
  ASSERT_TRUE(Comes([&] { return phase_ == "running"; }));
  now_s_ += 100;
  Start();
  EXPECT_TRUE(exams_->Sits(anna_));
  EXPECT_EQ(Own()["task"], 1) << "what was begun counts, until an examiner has it done again";
  EXPECT_THAT(Own()["cut"].get<std::string>(), HasSubstr("the gateway was killed"));
  ASSERT_TRUE(
      Comes([&] { return Trials()[0]["sealed"] == true && Trials()[1]["sealed"] == true; }));
  EXPECT_THAT(Trials()[1]["cut"].get<std::string>(), HasSubstr("the gateway was killed"));
  EXPECT_EQ(Own()["left_s"], 500);
  EXPECT_EQ(Json::parse(exams_->StateJson(0, true, now_s_))["open"]["down_s"], 100);
  ASSERT_EQ(Do("give_back"), "");
  EXPECT_EQ(Own()["left_s"], 600);
  ASSERT_EQ(Do("again", {{"person", anna_}}), "");
  EXPECT_EQ(Own()["task"], 0);
  EXPECT_EQ(Own()["trial"], 2);
}

TEST_F(ExamTest, TakesAndGivesNoTimeWhereTheComputersClockIsSet) {
  const auto told_s = [&] {
    return Json::parse(exams_->StateJson(0, true, now_s_))["open"]["set_by_s"].get<int>();
  };
  ASSERT_EQ(Open(), "");
  for (const int by_s : {1500, -3600}) {
    now_s_ += by_s;
    exams_->ClockWasSet(by_s);
    EXPECT_EQ(Own()["left_s"], 600) << "at once";
    exams_->Poll(now_s_);
    EXPECT_EQ(Own()["left_s"], 600);
  }
  EXPECT_EQ(told_s(), -2100);
  Start();
  EXPECT_EQ(Own()["left_s"], 600) << "the next process knows it, too";
  EXPECT_EQ(told_s(), 0);
  now_s_ -= 1800;
  Start();
  EXPECT_EQ(Own()["left_s"], 600) << "set back while none ran";
  EXPECT_EQ(told_s(), -1800);
  exams_->Poll(now_s_);
  now_s_ += 300;
  Start();
  EXPECT_EQ(Own()["left_s"], 300);
  ASSERT_EQ(Do("give_back"), "");
  EXPECT_EQ(Own()["left_s"], 600);
}

TEST_F(ExamTest, TakesNoTimeFromWhoWaitsForASeatAndGivesItToTheFirst) {
  const std::int64_t ben = roster_->Make({"Ben"}, Access::kDrive).front().person.id;
  std::vector<std::string> free;
  const ExamTurns::Seats seats{[&](std::int64_t, const std::string&) { return free; },
                               [](std::int64_t) { return true; }};
  const auto turn_of = [&](std::int64_t person) {
    return Json::parse(exams_->StateJson(person, false, now_s_))["open"]["turn"];
  };
  std::ofstream(folder_ / "course/midterm.exam.json")
      << R"({"title": "A", "time_s": 600, "order": "rotated",
             "tasks": [{"exercise": "light-force"}, {"exercise": "supragingival-calculus"}]})";
  ASSERT_EQ(Open(), "");
  EXPECT_EQ(turn_of(anna_)["scene"], "periodontal");
  EXPECT_EQ(turn_of(ben)["scene"], "calculus") << "who begins elsewhere";
  EXPECT_EQ(turn_of(anna_)["phase"], "ready");
  EXPECT_EQ(exams_->SeatToBegin(anna_, "light-force", now_s_, seats), "");
  now_s_ += 100;
  EXPECT_EQ(turn_of(anna_)["phase"], "waits");
  EXPECT_EQ(turn_of(anna_)["waits_s"], 100);
  EXPECT_EQ(Own()["left_s"], 600);
  exams_->Poll(now_s_);
  Start();
  EXPECT_EQ(turn_of(anna_)["phase"], "waits") << "after a kill, too";
  EXPECT_EQ(turn_of(anna_)["waits_s"], 100);
  free = {"periodontal-2"};
  exams_->CallNext(now_s_, seats);
  EXPECT_EQ(turn_of(anna_)["phase"], "called");
  EXPECT_EQ(turn_of(anna_)["seat"], "periodontal-2");
  EXPECT_TRUE(exams_->IsKept("periodontal-2"));
  now_s_ += 20;
  EXPECT_EQ(Own()["left_s"], 580) << "it goes on again";
  Try("light-force");
  EXPECT_EQ(Own()["left_s"], 580);
  EXPECT_FALSE(exams_->IsKept("periodontal-2"));
  EXPECT_EQ(turn_of(anna_)["scene"], "calculus");
  EXPECT_EQ(turn_of(anna_)["waited_s"], 100);
  const Roll roll =
      OpenRoll(ReadWholeFile(folder_ / "course/exams/midterm-1.roll.json", kLargestSeal),
               SealKey::ReadPublic(folder_ / "course/exam-key.pub.pem"), "it");
  EXPECT_EQ(roll.trials.at(0).waited_s, 100);
  now_s_ += 480;  // the time of those who have not waited
  exams_->Poll(now_s_);
  EXPECT_THAT(
      ComplaintOf([&] { exams_->SeatToBegin(ben, "supragingival-calculus", now_s_, seats); }),
      HasSubstr("time is over"));
  EXPECT_EQ(Begin("supragingival-calculus"), kGood);
}

TEST(ExamClock, FollowsTheSteadyClockAndTellsWhenTheOtherOneIsSet) {
  constexpr std::int64_t kS = 1'000'000'000;
  ExamClock clock(1000 * kS, 5 * kS);
  EXPECT_EQ(clock.Now_s(5 * kS), 1000);
  EXPECT_EQ(clock.Follow(1011 * kS, 15 * kS), 0) << "a second is its drift";
  EXPECT_EQ(clock.Now_s(15 * kS), 1010);
  EXPECT_EQ(clock.Follow(2511 * kS, 16 * kS), 1500);
  EXPECT_EQ(clock.Now_s(16 * kS), 2511);
  EXPECT_EQ(clock.Follow(2512 * kS, 17 * kS), 0) << "once";
  EXPECT_EQ(clock.Follow(-1087 * kS, 18 * kS), -3600);
  EXPECT_EQ(clock.Now_s(18 * kS), -1087);
}

TEST_F(ExamTest, EndsByItsTimeAndHasMoreWhereTheExaminerGivesIt) {
  EXPECT_THAT(Do("close"), HasSubstr("no exam is open"));
  ASSERT_EQ(Open(), "");
  ASSERT_EQ(Begin("light-force"), kGood);
  EXPECT_EQ(Own()["trial"], 1) << "that which runs";
  ASSERT_TRUE(Comes([&] { return phase_ == "running"; }));
  now_s_ += 600;
  ASSERT_TRUE(Comes([&] { return phase_ == "kept"; }));
  EXPECT_EQ(Own()["cut"], "") << "time ended it, as it was to";
  EXPECT_THAT(Begin("light-force"), HasSubstr("time is over"));
  ASSERT_EQ(Do("more", {{"s", 60}}), "");
  EXPECT_EQ(Own()["left_s"], 60);
  EXPECT_EQ(Begin("light-force"), kGood);
}

TEST_F(ExamTest, OpensNoOtherBeforeAllThatWasHandedInIsScoredAndOnTheRoll) {
  ASSERT_EQ(Open(), "");
  Try("light-force");
  ASSERT_TRUE(Comes([&] { return Trials()[0]["sealed"] == true; }));
  ASSERT_EQ(Do("close"), "");
  EXPECT_THAT(Open(), HasSubstr("being scored"));
  EXPECT_TRUE(exams_->Needs(anna_)) << "so nobody deletes her";
  ASSERT_TRUE(Comes([&] { return Trials()[0]["points"] == 81.5; }));
  EXPECT_FALSE(exams_->Needs(anna_));
  ASSERT_EQ(Open(), "");
  ASSERT_EQ(Do("close"), "");
  ASSERT_EQ(Open(), "") << "at once";
  EXPECT_TRUE(std::filesystem::exists(folder_ / "course/exams/midterm-2.roll.json"));
}

TEST_F(ExamTest, EndsTheKeysOfScorePagesOfThoseWhoSitIt) {
  const std::string theirs = folder_ / fmt::format("course/trials/{}/light-force", anna_);
  trials_->Begin(7, anna_, "light-force", "Anna", "periodontal", SteadyNanoseconds());
  ASSERT_TRUE(Comes([&] { return phase_ == "running"; }));
  trials_->End(7, "stopped");
  ASSERT_TRUE(Comes([&] { return phase_ == "scored"; }));
  const auto key = [&] { return trials_->pages().PagesOf(anna_).at({"light-force", 1}); };
  const std::string before = key();
  EXPECT_EQ(trials_->pages().PageOf(before), theirs + "/1/score.html");
  ASSERT_EQ(Open(), "");
  EXPECT_EQ(trials_->pages().PageOf(before), "");
  EXPECT_EQ(trials_->pages().PageOf(key()), theirs + "/1/score.html") << "only teachers may read";
}

TEST_F(ExamTest, IsNotScoredByOtherCriteriaThanThoseItWasOpenedWith) {
  const std::string own = folder_ / "course/exercises";
  std::filesystem::copy(PALPATE_SOURCE_DIR "/client/course/exercises", own);
  Start();
  ASSERT_EQ(Open(), "");
  Try("light-force");
  std::ofstream(own + "/light-force.exercise.json", std::ios::app) << "\n";
  ASSERT_EQ(Do("close"), "");
  ASSERT_TRUE(
      Comes([&] { return Json::parse(exams_->StateJson(0, true, now_s_))["trouble"] != ""; }));
  EXPECT_THAT(exams_->StateJson(0, true, now_s_), HasSubstr("'light-force' is not scored"));
  EXPECT_TRUE(Trials()[0]["points"].is_null());
}

}  // namespace
}  // namespace palpate::test
