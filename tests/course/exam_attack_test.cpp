// What somebody may do who can write into a course's folder, but has no key: whatever it is, what
// verify-exam calls verified is what was done.
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <random>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>
#include <unistd.h>

#include "client/course/exam_room.h"
#include "client/replayer/certificate/certificate.h"
#include "common/files/whole_file.h"
#include "common/realtime/steady_clock.h"
#include "common/text/hex16.h"
#include "scenes/catalogue.h"
#include "tests/replayer/hand_recording.h"
#include "tests/support/complaint.h"
#include "tests/support/eventually.h"
#include "tests/support/folder.h"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// A stand-in for the recorder: writes the first half of what was made for that station and trial,
/// and the rest when it is asked to end.
constexpr const char* kHalvingRecorder = R"(#!/bin/sh
for word; do case $word in
  --output=*) out=${word#--output=};;
  --station=*) who=${word#--station=};;
esac; done
made=$(dirname $0)/made/$who-$(basename $out)
half=$(($(stat -c %s $made) / 2))
head -c $half $made > $out
trap 'tail -c +$((half + 1)) $made >> $out; exit 0' INT
echo "recording to $out"
while :; do sleep 0.01; done
)";
constexpr const char* kIdleReplayer = R"(#!/bin/sh
for word; do case $word in --out=*) out=${word#--out=};; esac; done
mkdir -p $out && echo '{"passed": true, "trials": [{"points": 81.5}]}' > $out/score.json
)";
constexpr int kHalf = 400;  // poses

/// An exam of two trials for each of two people.
class ExamAttack : public testing::Test {
 protected:
  void SetUp() override {
    SetProgram("palpate-record", kHalvingRecorder);
    SetProgram("palpate-replay", kIdleReplayer);
    fs::create_directories(course_);
    fs::create_directory(folder_ / "made");
    const std::string shipped = PALPATE_SOURCE_DIR "/client/course/exercises/";
    fs::create_directory(course_ / "exercises");
    for (const char* const name : {"light-force.exercise.json", "light-force.path.json"}) {
      fs::copy(shipped + name, course_ / "exercises" / name);
    }
    Write("midterm.exam.json", R"({"title": "Midterm", "time_s": 600,
      "tasks": [{"exercise": "light-force", "trials": 2}]})");
    const Scene scene = LoadScene("cube");
    const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
    std::uint64_t run = 0;
    for (const char* const name : {"Anna-1", "Anna-2", "Ben-1", "Ben-2", "Anna-better"}) {
      ++run;
      const auto at = [run](std::uint64_t i) {
        return Pose{Vec3(1e-6 * static_cast<double>(i * run), 0.029, 0.0), Quat::Identity()};
      };
      hash_ = RecordHand(scene, model,
                         {std::string(name).substr(0, name[0] == 'A' ? 4 : 3), run, 2 * kHalf, at},
                         Made(name));
    }
    Start();
    for (const char* const name : {"Anna", "Ben"}) {
      people_.push_back(roster_->Make({name}, Access::kDrive).front().person.id);
    }
    roster_->Make({"teacher"}, Access::kOperate);
    key_ = folder_ / "key.pem";
    fs::copy(course_ / SealKey::kPublicFile, key_);
  }
  void SetProgram(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    fs::permissions(folder_ / name, fs::perms::owner_all);
  }
  std::string Made(const std::string& name) const { return folder_ / ("made/" + name + ".mcap"); }
  void Write(const std::string& file, const std::string& text) const {
    std::ofstream(course_ / file, std::ios::binary) << text;
  }
  std::string Read(const std::string& file) const { return ReadWholeFile(course_ / file, 1 << 24); }
  void Sql(const std::string& statement) const {
    SQLite::Database(course_ / "course.sqlite", SQLite::OPEN_READWRITE, 5000).exec(statement);
  }

  // --- what honest people do ---

  /// Ends the gateway at once, as kill -9 does.
  void Kill() {
    exams_.reset();
    trials_.reset();
    roster_.reset();
    file_.reset();
  }
  void Start() {
    Kill();
    file_ = std::make_unique<CourseFile>(course_);
    roster_ = std::make_unique<Roster>(*file_);
    trials_ = std::make_unique<TrialRoom>(TrialRoom::Options{course_, folder_.path(), {}}, *file_,
                                          [this](const TrialRoom::News& news) {
                                            phases_[news.person] = news.phase;
                                            if (exams_ && news.phase != "preparing")
                                              exams_->ReadOf(news.person);
                                          });
    exams_ = std::make_unique<ExamRoom>(course_, *file_, *roster_, *trials_, now_s_);
  }
  bool Comes(const std::function<bool()>& what) {
    return Eventually([&] {
      trials_->Poll(SteadyNanoseconds());
      exams_->Poll(now_s_);
      return what();
    });
  }
  std::string Do(const std::string& op, Json wish = Json::object()) {
    wish["op"] = op;
    wish["tag"] = 1;
    return Json::parse(exams_->Do(wish.dump(), now_s_))["refusal"];
  }
  Json State() const { return Json::parse(exams_->StateJson(0, true, now_s_)); }
  /// Begins a trial, and waits until half of it is recorded and marked.
  void Begin(std::size_t who, int n) {
    exams_->Begin({who + 1, people_[who], "light-force", who == 0 ? "Anna" : "Ben", "cube", hash_},
                  now_s_, SteadyNanoseconds());
    const std::string mark = StemOf(who, n) + kMarkEnding;
    ASSERT_TRUE(Comes([&] { return phases_[people_[who]] == "running"; }));
    // A gateway that waits for a disk does not poll.
    ASSERT_TRUE(Eventually([&] { return Json::parse(Read(mark))["sealed"]["bytes"] > 0; }));
  }
  void Try(std::size_t who, int n) {
    Begin(who, n);
    trials_->End(who + 1, "stopped");
    ASSERT_TRUE(Comes([&] { return phases_[people_[who]] == "kept"; }));
    ASSERT_TRUE(Settles());
  }
  /// Whether all that has ended is sealed, or known to be lost.
  bool Settles() {
    return Comes([&] {
      const Json state = State();
      if (state["trouble"] != "" || state["open"].is_null()) return true;
      for (const Json& person : state["open"]["people"]) {
        for (const Json& trial : person["trials"]) {
          if (!trial["running"] && !trial["sealed"] && trial["lost"] == "") return false;
        }
      }
      return true;
    });
  }
  /// Starts the next gateway, closes the exam where it is open, and waits until nothing is left.
  void Finish() {
    Start();
    Settles();
    if (State()["open"].is_object() && State()["open"]["closed"] == false) Do("close");
    Comes([&] {
      const std::string roll = TryReadWholeFile(course_ / kRoll, 1 << 20).value_or("");
      return State()["trouble"] != "" || State()["open"].is_null() ||
             roll.find("\"complete\":true") != roll.npos;
    });
    Kill();
  }
  std::string StemOf(std::size_t who, int n) const {
    return fmt::format("trials/{}/light-force/{}", people_[who], n);
  }

  // --- what is verified ---

  std::optional<Certificate> Verified() const {
    try {
      return VerifySealed({.folder = course_, .exam = "midterm", .key = key_});
    } catch (const Error&) {
      return std::nullopt;
    }
  }
  bool IsVerified() const {
    const auto certificate = Verified();
    return certificate && certificate->good();
  }
  /// Returns whether a trial was recorded as its seal says, wholly or up to where it was cut.
  bool IsHonest(const Seal& seal) const {
    if (seal.recording.empty()) return !seal.whole;
    const std::string made =
        ReadWholeFile(Made(fmt::format("{}-{}", seal.station, seal.n)), 1 << 24);
    const std::string begin = made.substr(0, static_cast<std::size_t>(seal.bytes));
    return Sha256(begin) == seal.sha256 && (!seal.whole || begin == made);
  }
  /// What is verified must be what was done, all of it.
  void ExpectNoLie(std::size_t trials, const std::string& what) const {
    const auto certificate = Verified();
    if (!certificate || !certificate->good()) return;
    EXPECT_EQ(certificate->trials.size(), trials) << what;
    for (const SealedVerdict& trial : certificate->trials) {
      EXPECT_TRUE(IsHonest(*trial.seal)) << what << ": " << trial.file;
      EXPECT_TRUE(trial.counts) << what << ": " << trial.file;
    }
  }

  static constexpr const char* kRoll = "exams/midterm-1.roll.json";
  const Folder folder_;
  const fs::path course_ = folder_ / "course";
  std::unique_ptr<CourseFile> file_;
  std::unique_ptr<Roster> roster_;
  std::unique_ptr<TrialRoom> trials_;
  std::unique_ptr<ExamRoom> exams_;
  std::map<std::int64_t, std::string> phases_;
  std::vector<std::int64_t> people_;
  std::uint64_t hash_ = 0;
  std::string key_;
  std::int64_t now_s_ = 1'800'000'000;
};

TEST_F(ExamAttack, OfNobodyIsVerifiedThroughTwoKills) {
  ASSERT_EQ(Do("open", {{"exam", "midterm"}}), "");
  Try(0, 1);
  Begin(1, 1);
  Start();
  ASSERT_TRUE(Settles());
  Begin(0, 2);
  Start();
  ASSERT_TRUE(Settles());
  Try(1, 2);
  ASSERT_EQ(Do("close"), "");
  Finish();
  const auto certificate = Verified();
  ASSERT_TRUE(certificate && certificate->good()) << (certificate ? ToText(*certificate) : "");
  ExpectNoLie(4, "nobody");
  EXPECT_TRUE(certificate->trials[0].seal->whole);
  EXPECT_FALSE(certificate->trials[1].seal->whole);
  EXPECT_EQ(certificate->trials[1].seal->bytes,
            static_cast<std::int64_t>(fs::file_size(Made("Anna-2")) / 2));
}

/// After an exam of one trial each, that of Ben cut short by a kill, all of it closed.
class ClosedExamAttack : public ExamAttack {
 protected:
  void SetUp() override {
    ExamAttack::SetUp();
    ASSERT_EQ(Do("open", {{"exam", "midterm"}}), "");
    Try(0, 1);
    Begin(1, 1);
    Kill();
    fs::copy(course_, running_, fs::copy_options::recursive);
    Finish();
    fs::copy(course_, closed_, fs::copy_options::recursive);
    ASSERT_TRUE(IsVerified());
  }
  void PutOtherRecording() const {
    fs::copy_file(Made("Anna-better"), course_ / (StemOf(0, 1) + ".mcap"),
                  fs::copy_options::overwrite_existing);
  }
  void PutBack(const fs::path& from, const std::string& file) const {
    if (!fs::exists(from / file)) return;
    fs::remove(course_ / file);
    fs::copy(from / file, course_ / file);
  }

  const fs::path running_ = folder_ / "running", closed_ = folder_ / "closed";
};

TEST_F(ClosedExamAttack, BySealingAnewIsNotVerified) {
  PutOtherRecording();
  for (const char* const file : {kRoll, ""}) {
    if (*file != '\0') fs::remove(course_ / file);
    Sql("UPDATE trials SET seal = NULL");
    for (const std::size_t who : {0, 1}) fs::remove(course_ / (StemOf(who, 1) + kSealEnding));
    Finish();
    EXPECT_FALSE(IsVerified());
  }
}

TEST_F(ClosedExamAttack, AsThoughItStillRanIsNotVerified) {
  PutOtherRecording();
  fs::remove(course_ / (StemOf(0, 1) + kSealEnding));
  Sql("UPDATE trials SET seal = NULL, ended_s = NULL");
  Sql("UPDATE exams SET closed_s = 0");
  Finish();
  EXPECT_FALSE(IsVerified());
  fs::remove(course_ / kRoll);
  Finish();
  EXPECT_FALSE(IsVerified());
}

TEST_F(ClosedExamAttack, ByDeletingATrialWithTheRollIsNotVerified) {
  for (const char* const ending : {".mcap", kSealEnding}) {
    fs::remove(course_ / (StemOf(1, 1) + ending));
  }
  EXPECT_FALSE(IsVerified());
  fs::remove(course_ / kRoll);
  EXPECT_FALSE(IsVerified());
  Sql(fmt::format("DELETE FROM trials WHERE person={}", people_[1]));
  Sql(fmt::format("DELETE FROM exam_trials WHERE person={}", people_[1]));
  Finish();
  EXPECT_FALSE(IsVerified());
}

TEST_F(ClosedExamAttack, WithoutARollIsNotVerified) {
  fs::remove(course_ / kRoll);
  EXPECT_FALSE(IsVerified());
  Finish();
  EXPECT_FALSE(IsVerified()) << "there is no new one";
}

TEST_F(ClosedExamAttack, WithOtherInputsOfItsGradeIsNotVerified) {
  for (const char* const file : {"midterm.exam.json", "exercises/light-force.exercise.json",
                                 "exercises/light-force.path.json"}) {
    const std::string good = Read(file);
    Write(file, good + "\n");
    EXPECT_FALSE(IsVerified()) << file;
    Write(file, good);
  }
  EXPECT_TRUE(IsVerified());
  fs::remove(course_ / "midterm.exam.json");
  EXPECT_FALSE(IsVerified());
}

TEST_F(ClosedExamAttack, WithTheStateOfAnEarlierMomentAndOtherRecordingsIsNotVerified) {
  fs::remove_all(course_);
  fs::copy(running_, course_, fs::copy_options::recursive);
  fs::copy_file(Made("Ben-2"), course_ / (StemOf(1, 1) + ".mcap"),
                fs::copy_options::overwrite_existing);
  Finish();
  EXPECT_FALSE(IsVerified());
}

TEST_F(ClosedExamAttack, AddsNothingToATrialThatAKillCutShort) {
  fs::remove_all(course_);
  fs::copy(running_, course_, fs::copy_options::recursive);
  const std::string recording = StemOf(1, 1) + ".mcap", half = Read(recording);
  Write(recording, half + "whatever follows");
  Finish();
  EXPECT_TRUE(Read(recording) == half);
  EXPECT_TRUE(IsVerified()) << "and the honest one is";
  ExpectNoLie(2, "a longer recording");
}

TEST_F(ClosedExamAttack, SealsNothingThatAKilledGatewaysRecorderStillWrites) {
  fs::remove_all(course_);
  fs::copy(running_, course_, fs::copy_options::recursive);
  const fs::path recording = course_ / (StemOf(1, 1) + ".mcap");
  const int recorder = open(recording.c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(flock(recorder, LOCK_EX), 0);
  Start();
  const auto is_sealed = [&] {
    return State()["open"]["people"][1]["trials"][0]["sealed"].get<bool>();
  };
  int looks = 0;
  EXPECT_TRUE(Comes([&] { return is_sealed() || ++looks > 50; }));
  EXPECT_FALSE(is_sealed());
  close(recorder);
  EXPECT_TRUE(Comes(is_sealed));
}

TEST_F(ClosedExamAttack, DoesNotHideATrialAsDoneAgain) {
  fs::remove_all(course_);
  fs::copy(running_, course_, fs::copy_options::recursive);
  Sql("UPDATE exam_trials SET counts = 0");
  Finish();
  ExpectNoLie(2, "in course.sqlite");
  EXPECT_TRUE(IsVerified());
}

TEST_F(ClosedExamAttack, ByAnyMixIsVerifiedOnlyAsItWasDone) {
  std::mt19937 random(20261129);
  const std::vector<std::string> files = {
      kRoll,
      "course.sqlite",
      StemOf(0, 1) + ".mcap",
      StemOf(1, 1) + ".mcap",
      StemOf(0, 1) + kSealEnding,
      StemOf(1, 1) + kSealEnding,
      StemOf(0, 1) + kMarkEnding,
      StemOf(1, 1) + kMarkEnding,
  };
  const auto any = [&](const auto& of) { return of[random() % of.size()]; };
  const std::vector<std::pair<std::string, std::function<void()>>> deeds = {
      {"delete", [&] { fs::remove(course_ / any(files)); }},
      {"put back", [&] { PutBack(random() % 2 == 0 ? running_ : closed_, any(files)); }},
      {"the better one", [&] { PutOtherRecording(); }},
      {"exchange",
       [&] {
         const std::string one = any(files), other = any(files);
         if (!fs::exists(course_ / one) || !fs::exists(course_ / other)) return;
         const std::string text = Read(one);
         Write(one, Read(other));
         Write(other, text);
       }},
      {"append", [&] { std::ofstream(course_ / any(files), std::ios::app) << "more"; }},
      {"sql",
       [&] {
         static const std::vector<std::string> kStatements = {
             "UPDATE trials SET seal = NULL",
             "UPDATE trials SET ended_s = NULL",
             "UPDATE trials SET whole = 1, reason = 'submitted'",
             "UPDATE exams SET closed_s = 0, ends_s = ends_s + 1000",
             "UPDATE exam_trials SET counts = 0",
             "DELETE FROM exam_trials WHERE rowid % 2 = 1",
             "DELETE FROM trials WHERE rowid % 2 = 0",
             "UPDATE exam_trials SET person = 3 - person"};
         try {
           Sql(any(kStatements));
         } catch (const SQLite::Exception&) {  // what it would do is not possible any more
         }
       }},
  };
  int verified = 0;
  for (int round = 0; round < 30; ++round) {
    fs::remove_all(course_);
    fs::copy(round % 2 == 0 ? running_ : closed_, course_, fs::copy_options::recursive);
    std::string what = fmt::format("round {}", round);
    for (int i = 0; i < 1 + round % 4; ++i) {
      const auto& [name, deed] = any(deeds);
      what += ", " + name;
      deed();
    }
    try {
      Finish();
    } catch (const Error&) {  // the folder is no course any more
      Kill();
    }
    ExpectNoLie(2, what);
    verified += IsVerified() ? 1 : 0;
  }
  EXPECT_GT(verified, 0) << "some deeds change nothing that counts";
}

}  // namespace
}  // namespace palpate::test
