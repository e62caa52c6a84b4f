#include "client/course/trial.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "client/course/roster.h"
#include "common/realtime/steady_clock.h"
#include "tests/support/complaint.h"
#include "tests/support/eventually.h"
#include "tests/support/folder.h"
#include "tests/support/read_file.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

/// Stand-ins under the recorder's and the replayer's names.
constexpr const char* kRecorder =
    "#!/bin/sh\ntrap 'exit 0' INT\necho \"$*\" > \"${0%/*}/words\"\necho \"recording to $1\"\n"
    "while :; do sleep 0.01; done\n";
constexpr const char* kReplayer = R"(#!/bin/sh
for word; do case $word in --out=*) out=${word#--out=};; esac; done
mkdir -p $out && echo page > $out/score.html
echo '{"passed": true, "trials": [{"points": 81.5, "marks": [{"criterion": "a"}]}]}' > $out/score.json
)";

class TrialTest : public testing::Test {
 protected:
  void SetUp() override {
    SetProgram("palpate-record", kRecorder);
    SetProgram("palpate-replay", kReplayer);
    Open();
  }
  void SetProgram(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    std::filesystem::permissions(folder_ / name, std::filesystem::perms::owner_all);
  }
  void Open() {
    room_.reset();
    file_.reset();
    file_ = std::make_unique<CourseFile>(folder_ / "course");
    file_->Use([](SQLite::Database& database) {  // as in an exam
      database.exec(
          "CREATE TABLE IF NOT EXISTS exam_trials(person INTEGER, exercise TEXT, n INTEGER)");
    });
    room_ = std::make_unique<TrialRoom>(
        TrialRoom::Options{folder_ / "course", folder_.path(), {}}, *file_,
        [this](const TrialRoom::News& news) { news_.push_back(news); });
  }
  void Begin() { room_->Begin(7, 3, "light-force", "anna", "periodontal-3", now_ns_); }
  bool Comes(const std::string& phase) {
    return Eventually([&] {
      room_->Poll(now_ns_);
      return !news_.empty() && news_.back().phase == phase;
    });
  }
  /// What the person's page is told about that trial.
  nlohmann::json Done(std::size_t at) {
    const auto list = nlohmann::json::parse(room_->pages().ListJson(3));
    for (const auto& exercise : list["exercises"]) {
      if (exercise["name"] == "light-force") return exercise["done"].at(at);
    }
    return {};
  }
  const Folder folder_;
  std::unique_ptr<CourseFile> file_;
  std::unique_ptr<TrialRoom> room_;
  std::vector<TrialRoom::News> news_;
  std::int64_t now_ns_ = SteadyNanoseconds();
};

TEST_F(TrialTest, IsRecordedThenScoredAndMayBeSubmitted) {
  Begin();
  EXPECT_EQ(news_.back().phase, "preparing");
  ASSERT_TRUE(Comes("running"));
  EXPECT_THAT(ReadWholeFile(folder_ / "words"), HasSubstr("--await-scene=periodontal-3"));
  EXPECT_EQ(news_.back().left_s, 90.0);
  EXPECT_THAT(ComplaintOf([&] { Begin(); }), HasSubstr("a trial of yours is running"));
  EXPECT_TRUE(room_->now().has_one_of(3));
  EXPECT_TRUE(room_->now().is_in("periodontal-3"));
  EXPECT_FALSE(room_->now().is_in("periodontal"));
  room_->End(8, "another's");
  room_->End(7, "stopped");
  ASSERT_TRUE(Comes("scored"));
  EXPECT_EQ(room_->now().size(), 0u);
  EXPECT_FALSE(room_->now().has_one_of(3));
  EXPECT_FALSE(room_->now().is_in("periodontal-3"));
  EXPECT_EQ(news_.back().reason, "stopped");
  EXPECT_TRUE(news_.back().whole && news_.back().passed);
  EXPECT_EQ(news_.back().points, 81.5);
  const std::string page = room_->pages().PageOf(news_.back().page);
  EXPECT_THAT(page, HasSubstr("/trials/3/light-force/1/score.html"));
  EXPECT_EQ(room_->pages().PageOf("0"), "");
  const std::pair<std::string, int> first{"light-force", 1};
  EXPECT_EQ(room_->pages().PagesOf(3).at(first), news_.back().page);
  EXPECT_TRUE(room_->pages().PagesOf(4).empty());
  EXPECT_EQ(Done(0)["points"], 81.5);
  EXPECT_EQ(Done(0)["submitted"], false);
  room_->Submit(7, 3, "light-force", 1);
  EXPECT_EQ(Done(0)["submitted"], true);
  EXPECT_THAT(ComplaintOf([&] { room_->Submit(7, 3, "light-force", 1); }),
              HasSubstr("no such trial"));
  EXPECT_THAT(ComplaintOf([&] { room_->Begin(7, 3, "none", "anna", "periodontal-3", now_ns_); }),
              HasSubstr("there is no exercise"));
}

TEST_F(TrialTest, HasAScorePageThatBearsItsPersonsName) {
  Roster(*file_).Make({"Anna", "Ben", "王伟"}, Access::kDrive);
  SetProgram("palpate-replay",
             std::string("#!/bin/sh\necho \"$@\" > \"$(dirname \"$0\")/said\"\n") +
                 (kReplayer + sizeof("#!/bin/sh")));
  Begin();
  ASSERT_TRUE(Comes("running"));
  room_->End(7, "stopped");
  ASSERT_TRUE(Comes("scored"));
  EXPECT_THAT(ReadWholeFile(folder_ / "said"), HasSubstr("--person=王伟"));
}

TEST_F(TrialTest, WaitsWithItsScoreWhileAnotherProgramHoldsTheCoursesFile) {
  Begin();
  ASSERT_TRUE(Comes("running"));
  SQLite::Database other(folder_ / "course/course.sqlite", SQLite::OPEN_READWRITE);
  other.exec("BEGIN IMMEDIATE");
  room_->End(7, "stopped");
  for (int i = 0; i < 300; ++i) {  // until its recorder and its scorer have long ended
    now_ns_ += 50'000'000;
    room_->Poll(now_ns_);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(room_->now().size(), 1u);
  EXPECT_NE(news_.back().phase, "unscored");
  other.exec("COMMIT");
  ASSERT_TRUE(Eventually([&] {
    now_ns_ += 50'000'000;
    room_->Poll(now_ns_);
    return news_.back().phase == "scored";
  }));
  EXPECT_TRUE(news_.back().whole);
  EXPECT_EQ(news_.back().reason, "stopped");
  EXPECT_EQ(Done(0)["points"], 81.5);
}

TEST_F(TrialTest, IsNeitherRecordedNorScoredThroughALink) {
  namespace fs = std::filesystem;
  const Folder elsewhere;
  fs::create_directories(folder_ / "course/trials/3/light-force");
  fs::create_directory_symlink(elsewhere.path(), folder_ / "course/trials/3/light-force/1");
  Begin();
  ASSERT_TRUE(Comes("running"));
  room_->End(7, "stopped");
  ASSERT_TRUE(Comes("scored"));
  EXPECT_TRUE(fs::is_empty(elsewhere.path()));
  fs::rename(folder_ / "course/trials/3", elsewhere / "3");
  fs::create_directory_symlink(elsewhere / "3", folder_ / "course/trials/3");
  EXPECT_THAT(ComplaintOf([&] { Begin(); }), HasSubstr("is a link"));
}

TEST_F(TrialTest, EndsByItsTimeAndWhereItIsSubmitted) {
  Begin();
  ASSERT_TRUE(Comes("running"));
  now_ns_ += 91'000'000'000;
  ASSERT_TRUE(Comes("scored"));
  EXPECT_EQ(news_.back().reason, "the time is over");
  Begin();
  ASSERT_TRUE(Comes("running"));
  room_->Submit(7, 3, "light-force", 0);
  ASSERT_TRUE(Comes("scored"));
  EXPECT_EQ(news_.back().n, 2);
  EXPECT_EQ(Done(1)["submitted"], true);
}

TEST_F(TrialTest, GoesOnWithThePageThatComesInPlaceOfAnother) {
  Begin();
  EXPECT_EQ(room_->now().HolderOf(3), 0u) << "it does not run yet";
  ASSERT_TRUE(Comes("running"));
  EXPECT_EQ(room_->now().HolderOf(3), 7u);
  room_->Return(7, 9, now_ns_ + 20'000'000'000);
  EXPECT_EQ(news_.back().holder, 9u);
  EXPECT_NEAR(news_.back().left_s, 70.0, 1e-6);
  EXPECT_TRUE(room_->now().is_running(9));
  EXPECT_FALSE(room_->now().is_running(7));
}

TEST_F(TrialTest, DoesNotCountWhereItWasCutShort) {
  Begin();
  ASSERT_TRUE(Comes("running"));
  room_->End(7, "cut short: its page did not come back", false);
  ASSERT_TRUE(Comes("scored"));
  EXPECT_EQ(Done(0)["whole"], false);
  EXPECT_THAT(std::string(Done(0)["reason"]), HasSubstr("cut short"));
}

TEST_F(TrialTest, IsNotWholeWhereItsRecorderFailsOrDies) {
  SetProgram("palpate-record",
             "#!/bin/sh\necho 'recording to x'\nsleep 0.1\n"
             "echo 'palpate-record: 1.mcap: No space left on device' >&2\nexit 1\n");
  Begin();
  ASSERT_TRUE(Comes("scored")) << "what there is counts for what it is";
  EXPECT_FALSE(news_.back().whole);
  EXPECT_THAT(news_.back().reason, HasSubstr("No space left on device"));
  SetProgram("palpate-record", "#!/bin/sh\necho 'recording to x'\nkill -9 $$\n");
  SetProgram("palpate-replay",
             "#!/bin/sh\necho 'palpate-replay: 2.mcap: holds no hand' >&2\nexit 1\n");
  Begin();
  ASSERT_TRUE(Comes("unscored"));
  EXPECT_EQ(Done(1)["whole"], false);
  EXPECT_THAT(Done(1)["reason"].get<std::string>(), HasSubstr("recorder was killed"));
  EXPECT_THAT(news_.back().reason, HasSubstr("2.mcap: holds no hand"));
}

TEST_F(TrialTest, IsNotWholeWhereItsStationHasComeAgain) {
  SetProgram("palpate-replay",
             "#!/bin/sh\necho 'palpate-replay: 1.mcap: holds 2 sessions; choose one: --station "
             "anna/1' >&2\nexit 1\n");
  Begin();
  ASSERT_TRUE(Comes("running"));
  room_->End(7, "stopped");
  ASSERT_TRUE(Comes("unscored"));
  EXPECT_EQ(Done(0)["whole"], false);
  EXPECT_THAT(Done(0)["reason"].get<std::string>(), HasSubstr("holds 2 sessions"));
}

TEST_F(TrialTest, IsNotWholeIfItsScoreSaysThatItIsNotComplete) {
  std::string lacking = kReplayer;
  const std::string points = "\"points\": 81.5";
  lacking.replace(lacking.find(points), points.size(),
                  points + ", \"incomplete\": \"it is cut off\"");
  SetProgram("palpate-replay", lacking);
  Begin();
  ASSERT_TRUE(Comes("running"));
  room_->End(7, "stopped");
  ASSERT_TRUE(Comes("scored"));
  EXPECT_EQ(Done(0)["whole"], false);
  EXPECT_EQ(Done(0)["reason"], "stopped; it is cut off");
}

TEST_F(TrialTest, HasPointsAndIsNotWholeWhereItsSessionsAreJoined) {
  std::string joined = kReplayer;
  const std::string points = "\"points\": 81.5";
  joined.replace(joined.find(points), points.size(), points + ", \"sessions\": 3");
  SetProgram("palpate-replay", joined);
  Begin();
  ASSERT_TRUE(Comes("running"));
  room_->End(7, "stopped");
  ASSERT_TRUE(Comes("scored"));
  EXPECT_EQ(news_.back().points, 81.5);
  EXPECT_EQ(Done(0)["whole"], false);
  EXPECT_EQ(Done(0)["reason"], "stopped; its station lost the server and came again, 2 times");
}

TEST_F(TrialTest, IsMarkedAsCutShortWhereTheGatewayWasKilledAndScoredByTheNext) {
  Begin();
  ASSERT_TRUE(Comes("running"));
  Open();
  EXPECT_EQ(Done(0)["whole"], false);
  EXPECT_THAT(Done(0)["reason"].get<std::string>(), HasSubstr("cut short"));
  room_->ScoreLeftovers();
  Begin();
  EXPECT_EQ(news_.back().n, 2) << "nobody waits for an old one";
  ASSERT_TRUE(Comes("running"));
  room_->End(7, "stopped");
  ASSERT_TRUE(Eventually([&] {
    room_->Poll(now_ns_);
    return room_->now().size() == 0;
  }));
  EXPECT_EQ(Done(0)["points"], 81.5);
  EXPECT_EQ(Done(0)["whole"], false);
  EXPECT_EQ(Done(1)["points"], 81.5);
}

TEST_F(TrialTest, IsScoredByTheNextGatewayWhereScoringFailedOrWasCutOff) {
  SetProgram("palpate-replay", "#!/bin/sh\necho 'palpate-replay: No space left' >&2\nexit 1\n");
  Begin();
  ASSERT_TRUE(Comes("running"));
  room_->End(7, "stopped");
  ASSERT_TRUE(Comes("unscored"));
  SetProgram("palpate-replay", "#!/bin/sh\nsleep 100\n");
  Begin();
  ASSERT_TRUE(Comes("running"));
  room_->End(7, "stopped");
  ASSERT_TRUE(Comes("scoring"));
  SetProgram("palpate-replay", kReplayer);
  Open();
  file_->Use([](SQLite::Database& database) {
    database.exec("INSERT INTO exam_trials VALUES(3, 'light-force', 3)");
    database.exec(
        "INSERT INTO trials(person, exercise, n, begun_s, ended_s, whole) "
        "VALUES(3, 'light-force', 3, 1, 2, 1), (4, 'no-more', 1, 1, 2, 1)");
  });
  room_->ScoreLeftovers();
  ASSERT_TRUE(Eventually([&] {
    room_->Poll(now_ns_);
    return room_->now().size() == 0;
  }));
  for (const std::size_t at : {0u, 1u}) {
    EXPECT_EQ(Done(at)["points"], 81.5);
    EXPECT_EQ(Done(at)["reason"], "stopped");
    EXPECT_EQ(Done(at)["whole"], true);
  }
  EXPECT_TRUE(Done(2)["points"].is_null()) << "an exam's waits for its end";
}

TEST_F(TrialTest, IsScoredInItsTurnWhereManyEndAtOnce) {
  SetProgram("palpate-record", "#!/bin/sh\necho 'recording to x'\nexit 0\n");
  // Counts how many run at once, by a file of each.
  SetProgram("palpate-replay", "#!/bin/sh\ncd " + folder_.path() +
                                   "\ntouch work.$$; ls work.* | wc -l >> most; sleep 0.02; "
                                   "rm work.$$\n" +
                                   (kReplayer + sizeof("#!/bin/sh")));
  for (int person = 1; person <= 12; ++person) {
    TrialRoom::News ended;
    ended.person = person;
    ended.exercise = "light-force";
    ended.n = 1;
    room_->Score(ended, 90.0);
  }
  ASSERT_TRUE(Eventually([&] {
    room_->Poll(now_ns_);
    return room_->now().size() == 0;
  }));
  EXPECT_EQ(std::ranges::count(news_, "scored", &TrialRoom::News::phase), 12);
  std::ifstream most(folder_ / "most");
  for (int at_work = 0; most >> at_work;) EXPECT_LE(at_work, 4);
  int last = 12;
  for (const TrialRoom::News& news : news_) {
    if (news.person != 12 || news.phase != "waiting") continue;
    EXPECT_LT(news.ahead, last) << "who is told a place in the queue moves up in it";
    last = news.ahead;
  }
  EXPECT_LT(last, 5) << "and was told so up to the end";
}

TEST_F(TrialTest, IsUnscoredWhereItsScoringHangsAndScoredAtTheNextStart) {
  SetProgram("palpate-replay", "#!/bin/sh\nexec sleep 1000\n");
  Begin();
  ASSERT_TRUE(Comes("running"));
  room_->End(7, "stopped");
  ASSERT_TRUE(Comes("scoring"));
  room_->Poll(now_ns_);
  now_ns_ += 300'000'000'000;  // of 30 s, and 4 s for each of the 90 s that a trial may take
  room_->Poll(now_ns_);
  EXPECT_EQ(news_.back().phase, "scoring");
  now_ns_ += 100'000'000'000;
  ASSERT_TRUE(Comes("unscored"));
  EXPECT_THAT(news_.back().reason,
              testing::StartsWith("its scoring hung and was ended after 390 s"));
  EXPECT_THAT(news_.back().reason, HasSubstr("the recording is kept"));
  EXPECT_TRUE(news_.back().whole);
  Begin();  // the person goes on
  ASSERT_TRUE(Comes("running"));
  SetProgram("palpate-replay", kReplayer);
  Open();
  room_->ScoreLeftovers();
  ASSERT_TRUE(Eventually([&] {
    room_->Poll(now_ns_);
    return room_->now().size() == 0;
  }));
  EXPECT_EQ(Done(0)["points"], 81.5);
  EXPECT_EQ(Done(0)["reason"], "stopped");
}

TEST_F(TrialTest, TellsTheTruthWhereItsEndCannotBeEntered) {
  Begin();
  ASSERT_TRUE(Comes("running"));
  int pages = 0;
  file_->Use([&](SQLite::Database& database) {  // as a full disk: not a page more
    database.exec("PRAGMA wal_checkpoint(TRUNCATE)");
    pages = database.execAndGet("PRAGMA page_count").getInt();
    database.exec("PRAGMA max_page_count=" + std::to_string(pages));
  });
  room_->End(7, "stopped" + std::string(20'000, '!'));
  ASSERT_TRUE(Comes("unentered"));
  EXPECT_THAT(news_.back().reason, HasSubstr("the disk is full"));
  EXPECT_THAT(ComplaintOf([&] { Begin(); }),
              testing::AllOf(HasSubstr("its recording is kept"), HasSubstr("the disk is full"),
                             testing::Not(HasSubstr("is running"))));
  file_->Use([&](SQLite::Database& database) {
    database.exec("PRAGMA max_page_count=" + std::to_string(pages + 1000));
  });
  now_ns_ += 3'000'000'000;
  ASSERT_TRUE(Comes("scored"));
  Begin();
  EXPECT_EQ(news_.back().phase, "preparing");
}

TEST_F(TrialTest, WaitsForAScoreInTheOrderOfEndsNotOfBeginnings) {
  SetProgram("palpate-replay", "#!/bin/sh\nexec sleep 1000\n");
  constexpr int kPeople = 12;
  for (int person = 1; person <= kPeople; ++person) {
    const auto holder = static_cast<TrialRoom::Holder>(person);
    room_->Begin(holder, person, "light-force", "anna", "periodontal-3", now_ns_);
  }
  const auto newest = [&](int person) {
    const auto last =
        std::ranges::find(news_.rbegin(), news_.rend(), person, &TrialRoom::News::person);
    return last == news_.rend() ? TrialRoom::News() : *last;
  };
  const auto come_to = [&](int person, const std::string& phase) {
    return Eventually([&] {
      room_->Poll(now_ns_);
      return newest(person).phase == phase;
    });
  };
  for (int person = 1; person <= kPeople; ++person) ASSERT_TRUE(come_to(person, "running"));
  // The last to begin end first; the first four are followed by scorers of their own.
  std::vector<int> ahead;
  for (int person = kPeople; person > 4; --person) {
    room_->End(static_cast<TrialRoom::Holder>(person), "stopped");
    ASSERT_TRUE(Eventually([&] {
      room_->Poll(now_ns_);
      return newest(person).phase == "scoring" || newest(person).phase == "waiting";
    }));
    if (newest(person).phase == "waiting") ahead.push_back(newest(person).ahead);
  }
  ASSERT_GE(ahead.size(), 4u);
  EXPECT_TRUE(std::ranges::is_sorted(ahead));
  for (int person = kPeople; person > 4; --person) {
    const auto told = [&](const TrialRoom::News& news) {
      return news.person == person && news.phase == "waiting";
    };
    EXPECT_LE(std::ranges::count_if(news_, told), 1) << "nobody who came later was put before";
  }
}

TEST_F(TrialTest, MayBeSubmittedWhileItIsScored) {
  SetProgram("palpate-replay",
             std::string("#!/bin/sh\nsleep 0.2\n") + (kReplayer + sizeof("#!/bin/sh")));
  Begin();
  ASSERT_TRUE(Comes("running"));
  room_->End(7, "stopped");
  ASSERT_TRUE(Comes("scoring"));
  room_->Submit(7, 3, "light-force", 1);
  ASSERT_TRUE(Comes("scored"));
  EXPECT_EQ(Done(0)["submitted"], true);
}

}  // namespace
}  // namespace palpate::test
