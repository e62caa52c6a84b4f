#include "client/course/trial.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <random>
#include <utility>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "client/course/history.h"
#include "common/error.h"
#include "common/files/project_files.h"
#include "common/files/whole_file.h"
#include "common/program/machine.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// After this time a recorder that has not ended is killed.
constexpr std::int64_t kPatience_ns = 10'000'000'000;
/// And one that has not begun: it waits for its scene, which twenty ask for at once in a class.
constexpr std::int64_t kBeginPatience_ns = 30'000'000'000;
constexpr std::int64_t kRetry_ns = 2'000'000'000;
constexpr std::int64_t kHeld_ns = 200'000'000;  // between tries while another holds the file
/// Trials scored while they run; each keeps the solids of its scene in memory
/// (tests/benchmarks/results/course.md).  Other trials are scored after they end, at most one per
/// processor and no more than this number at a time.
constexpr int kMostFollowing = 4;
/// A scoring that takes longer than kScore_s, and kScorePerSecond for each second of the trial,
/// hangs and is ended.  It computes a cut of the expert and one of the trial, at rest in a third of
/// the trial's time; a host whose load is twelve times its processors takes four times the trial's
/// time.
constexpr double kScore_s = 30.0, kScorePerSecond = 4.0;
constexpr std::size_t kLargestScore = std::size_t{16} << 20;
/// In palpate-replay's complaint if the station lost its server and came again.
constexpr std::string_view kSeveralSessions = "sessions; choose one";
constexpr std::string_view kNoScore = "no score: ";
constexpr const char* kTrialsTable =
    "CREATE TABLE IF NOT EXISTS trials(person INTEGER NOT NULL, exercise TEXT NOT NULL, "
    "n INTEGER NOT NULL, begun_s INTEGER NOT NULL, ended_s INTEGER, reason TEXT, "
    "whole INTEGER, points REAL, passed INTEGER, marks TEXT, submitted_s INTEGER, seal TEXT, "
    "PRIMARY KEY(person, exercise, n))";

std::int64_t Now_s() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// Pages warn of a tissue to be spared at least from this distance on.
constexpr double kLeastWarning_mm = 0.5;

Json JsonOf(const LocalText& text) {
  Json json = Json::object();
  for (const auto& [language, words] : text) json[language] = words;
  return json;
}

Json JsonOf(const Exercise& exercise) {
  Json pictures = Json::array();
  for (const Exercise::Picture& picture : exercise.pictures) {
    pictures.push_back({{"path", "exercise/" + exercise.name + "/" + picture.file},
                        {"text", JsonOf(picture.text)}});
  }
  Json guide = Json::array();
  for (const auto& [t, X, label] : exercise.guide) {
    guide.push_back({t, X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()});
  }
  double weights = 0.0;
  for (const Criterion& criterion : exercise.criteria.criteria) weights += criterion.weight;
  Json graded = Json::array();
  for (const Criterion& criterion : exercise.criteria.criteria) {
    graded.push_back({{"name", JsonOf(criterion.names)},
                      {"points", 100.0 * criterion.weight / weights},
                      {"gates", criterion.gates},
                      {"harms", criterion.harms}});
  }
  Json guards = Json::array();
  for (const Criterion& criterion : exercise.criteria.criteria) {
    if (criterion.measure != "thickness_mm") continue;
    guards.push_back(
        {{"tissue", criterion.tissue}, {"within_mm", std::max(criterion.best, kLeastWarning_mm)}});
  }
  const char* const starts[] = {"whole", "bookmark", "as_it_is"};
  return {{"name", exercise.name},
          {"title", JsonOf(exercise.title)},
          {"scene", exercise.scene_name},
          {"tool", exercise.tool},
          {"tools", exercise.tools},
          {"start", starts[static_cast<int>(exercise.start)]},
          {"instruction", JsonOf(exercise.instruction)},
          {"goal", JsonOf(exercise.goal)},
          {"pictures", pictures},
          {"most_N", exercise.most_N},
          {"most_s", exercise.most_s},
          {"trials", exercise.trials},
          {"pass", exercise.criteria.pass},
          {"graded", graded},
          {"sources", exercise.sources},
          {"guide", guide},
          {"guards", guards},
          {"done", Json::array()}};
}

}  // namespace

TrialRoom::TrialRoom(Options options, CourseFile& file, std::function<void(const News&)> tell)
    : options_(std::move(options)), lock_(options_.folder), file_(file), tell_(std::move(tell)) {
  const auto refused = [](const std::string& why) {
    spdlog::error("{} (this exercise is skipped)", Printable(why));
  };
  exercises_ = LoadExercises(options_.folder + "/exercises", refused);
  for (Exercise& shipped : LoadExercises(PlaceOf(ProjectFile::kExercises), refused)) {
    if (Find(shipped.name) == nullptr) exercises_.push_back(std::move(shipped));
  }
  file_.Use([](SQLite::Database& database) { database.exec(kTrialsTable); });
  MarkCutShort();
}

void TrialRoom::MarkCutShort() {
  file_.Use([this](SQLite::Database& database) {
    SQLite::Statement cut(database, "SELECT person, exercise, n FROM trials WHERE ended_s IS NULL");
    while (cut.executeStep()) {
      News news;
      news.person = cut.getColumn(0).getInt64();
      news.exercise = cut.getColumn(1).getString();
      news.n = cut.getColumn(2).getInt();
      spdlog::warn(
          "{} was interrupted when the gateway was killed; its recording lacks at most the last "
          "half second",
          NameOf(news));
    }
    SQLite::Statement mark(database,
                           "UPDATE trials SET ended_s=?, whole=0, reason='cut short: the gateway "
                           "was killed' WHERE ended_s IS NULL");
    mark.bind(1, Now_s());
    mark.exec();
  });
}

const Exercise* TrialRoom::Find(const std::string& exercise) const {
  const auto found = std::ranges::find(exercises_, exercise, &Exercise::name);
  return found == exercises_.end() ? nullptr : &*found;
}

std::string TrialRoom::FolderOf(std::int64_t person, const std::string& exercise) const {
  return fmt::format("{}/trials/{}/{}", options_.folder, person, exercise);
}

bool TrialRoom::is_at_one(Holder holder) const {
  return std::ranges::any_of(
      trials_, [&](const Running& trial) { return trial.news.holder == holder && trial.records; });
}

bool TrialRoom::is_in(const std::string& scene) const {
  return std::ranges::any_of(
      trials_, [&](const Running& trial) { return trial.records && trial.scene == scene; });
}

bool TrialRoom::is_cut_in(const std::string& scene) const {
  return std::ranges::any_of(trials_, [&](const Running& trial) {
    return trial.records && trial.scene == scene && AsksForCuts(trial.exercise->criteria);
  });
}

bool TrialRoom::has_one_of(std::int64_t person) const {
  return std::ranges::any_of(trials_,
                             [&](const Running& trial) { return trial.news.person == person; });
}

bool TrialRoom::Has(std::int64_t person, const std::string& exercise, int n) const {
  return std::ranges::any_of(trials_, [&](const Running& trial) {
    return trial.news.person == person && trial.news.exercise == exercise && trial.news.n == n;
  });
}

void TrialRoom::CheckMayBegin(std::int64_t person) const {
  const auto theirs = std::ranges::find_if(trials_, [&](const Running& trial) {
    return trial.news.person == person && trial.news.holder != 0;
  });
  if (theirs == trials_.end()) return;
  if (theirs->retry_ns != 0) {
    throw Error(fmt::format(
        "your last trial is over and its recording is kept, but it cannot be entered: {}. It is "
        "entered as soon as that is mended, and then you may begin; tell your teacher",
        theirs->trouble));
  }
  throw Error(theirs->records ? "a trial of yours is running; end it first"
                              : "your last trial is being scored; wait for its points");
}

int TrialRoom::Begin(Holder holder, std::int64_t person, const std::string& exercise,
                     const std::string& station, const std::string& scene, std::int64_t now_ns,
                     std::optional<double> exam_s) {
  Running trial;
  trial.exercise = Find(exercise);
  if (trial.exercise == nullptr) throw Error("there is no exercise " + Quoted(exercise));
  CheckMayBegin(person);
  trial.news.holder = holder;
  trial.news.person = person;
  trial.news.exercise = exercise;
  trial.scene = scene;
  trial.asked_ns = now_ns;
  trial.is_exam = trial.submits = exam_s.has_value();
  trial.most_s = exam_s.value_or(trial.exercise->most_s);
  const std::string folder = FolderOf(person, exercise);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw Error(folder + ": " + error.message() +
                "; cannot record there; check the folder's rights and the space on its disk");
  RefuseLinks(options_.folder, folder);
  file_.Use([&](SQLite::Database& database) {
    SQLite::Statement last(database,
                           "SELECT IFNULL(MAX(n), 0) FROM trials WHERE person=? AND exercise=?");
    last.bind(1, person);
    last.bind(2, exercise);
    last.executeStep();
    trial.news.n = last.getColumn(0).getInt() + 1;
    SQLite::Statement row(database,
                          "INSERT INTO trials(person, exercise, n, begun_s) VALUES(?, ?, ?, ?)");
    row.bind(1, person);
    row.bind(2, exercise);
    row.bind(3, trial.news.n);
    row.bind(4, Now_s());
    row.exec();
  });
  std::vector<std::string> arguments{fmt::format("--output={}/{}.mcap", folder, trial.news.n),
                                     "--station=" + station, "--await-scene=" + scene};
  arguments.insert(arguments.end(), options_.network.begin(), options_.network.end());
  trials_.push_back(std::move(trial));
  Running& begun = trials_.back();
  begun.records = true;
  begun.recorder =
      std::make_unique<ChildProgram>(options_.programs + "/palpate-record", arguments,
                                     "the trial's recorder", [&begun](const std::string& line) {
                                       spdlog::debug("recorder: {}", line);
                                       if (line.starts_with("recording to ") && begun.began_ns == 0)
                                         begun.began_ns = -1;
                                     });
  Tell(begun, "preparing");
  return begun.news.n;
}

void TrialRoom::BeginToEnd(Running& trial, const std::string& reason) {
  if (!trial.records || trial.news.phase == "ending" || trial.retry_ns != 0) return;
  trial.news.reason = reason;
  trial.asked_ns = 0;
  trial.recorder->Signal(SIGINT);
  Tell(trial, "ending");
}

void TrialRoom::End(Holder holder, const std::string& reason, bool whole) {
  for (Running& trial : trials_) {
    if (trial.news.holder != holder || trial.news.phase == "ending") continue;
    trial.news.whole = trial.news.whole && whole;
    BeginToEnd(trial, reason);
  }
}

bool TrialRoom::is_running(Holder holder) const {
  return std::ranges::any_of(trials_, [&](const Running& trial) {
    return trial.news.holder == holder && trial.news.phase == "running";
  });
}

TrialRoom::Holder TrialRoom::HolderOf(std::int64_t person) const {
  const auto runs = std::ranges::find_if(trials_, [&](const Running& trial) {
    return trial.news.person == person && trial.news.phase == "running";
  });
  return runs == trials_.end() ? 0 : runs->news.holder;
}

void TrialRoom::Return(Holder holder, Holder to, std::int64_t now_ns) {
  for (Running& trial : trials_) {
    if (trial.news.holder != holder || trial.news.phase != "running") continue;
    trial.news.holder = to;
    trial.news.left_s = trial.most_s - 1e-9 * static_cast<double>(now_ns - trial.began_ns);
    Tell(trial, "running");
  }
}

void TrialRoom::EndOf(const std::set<std::int64_t>& people, const std::string& reason) {
  for (Running& trial : trials_) {
    if (people.contains(trial.news.person)) BeginToEnd(trial, reason);
  }
}

void TrialRoom::EndIn(const std::string& scene, const std::string& reason) {
  for (Running& trial : trials_) {
    if (!trial.records || trial.scene != scene) continue;
    trial.news.whole = false;
    BeginToEnd(trial, reason);
  }
}

void TrialRoom::Submit(Holder holder, std::int64_t person, const std::string& exercise, int n) {
  for (Running& trial : trials_) {
    if (!trial.records || trial.news.holder != holder || trial.news.exercise != exercise) continue;
    trial.submits = true;
    return BeginToEnd(trial, "submitted");
  }
  file_.Use([&](SQLite::Database& database) {
    SQLite::Statement row(database,
                          "UPDATE trials SET submitted_s=? WHERE person=? AND exercise=? AND n=? "
                          "AND ended_s IS NOT NULL AND submitted_s IS NULL");
    row.bind(1, Now_s());
    row.bind(2, person);
    row.bind(3, exercise);
    row.bind(4, n);
    if (row.exec() != 1) throw Error("there is no such trial to submit");
  });
}

void TrialRoom::Tell(Running& trial, const std::string& phase) {
  trial.news.phase = phase;
  tell_(trial.news);
}

bool TrialRoom::PollOne(Running& trial, std::int64_t now_ns) {
  if (trial.asked_ns == 0) trial.asked_ns = now_ns;
  const bool is_scoring = trial.scorer && trial.scorer->Poll();
  if (!trial.records) {
    if (trial.cuts_short && trial.follows) {
      trial.cuts_short = false;
      trial.scorer->Signal(SIGINT);
    }
    if (is_scoring && !trial.is_overdue &&
        1e-9 * static_cast<double>(now_ns - trial.asked_ns) > MostToScore_s(trial)) {
      trial.is_overdue = true;
      trial.scorer->Signal(SIGKILL);
    }
    if (is_scoring || !trial.scorer || now_ns < trial.retry_ns) return true;
    trial.retry_ns = now_ns + kHeld_ns;
    TakeScore(trial);
    return false;
  }
  const bool runs = trial.recorder->Poll();
  if (runs) {
    if (trial.began_ns == -1) {
      trial.began_ns = now_ns;
      trial.news.left_s = trial.most_s;
      // A trial of an exam is scored after the exam is closed.
      const auto following = std::ranges::count_if(
          trials_, [](const Running& other) { return other.records && other.scorer; });
      if (!trial.is_exam && following < kMostFollowing) BeginScoring(trial, true);
      Tell(trial, "running");
    }
    const bool in_time = 1e-9 * static_cast<double>(now_ns - trial.began_ns) < trial.most_s;
    if (trial.news.phase == "running") {
      if (!in_time) BeginToEnd(trial, "the time is over");
    } else if (now_ns - trial.asked_ns >
               (trial.news.phase == "preparing" ? kBeginPatience_ns : kPatience_ns)) {
      trial.recorder->Signal(SIGKILL);
    }
    return true;
  }
  const std::string& complaint = trial.recorder->complaint();
  if (trial.news.phase == "ending" && trial.began_ns == 0) {
    trial.news.whole = false;  // a recorder that has not begun dies of being told to end
  } else if (trial.retry_ns == 0 && (trial.news.phase != "ending" || !complaint.empty())) {
    trial.news.whole = false;
    trial.news.reason = "not whole: " + (complaint.empty() ? "its recorder ended" : complaint);
    spdlog::error("{}: {}", NameOf(trial.news), Printable(trial.news.reason));
  }
  if (!Keep(trial, now_ns)) return true;
  if (trial.is_exam) {
    Tell(trial, "kept");
    return false;
  }
  Score(trial);
  return true;
}

bool TrialRoom::Keep(Running& trial, std::int64_t now_ns) try {
  if (now_ns < trial.retry_ns) return false;
  const News& news = trial.news;
  file_.Use([&](SQLite::Database& database) {
    SQLite::Statement row(database,
                          "UPDATE trials SET ended_s=?, reason=?, whole=?, submitted_s=? WHERE "
                          "person=? AND exercise=? AND n=?");
    row.bind(1, Now_s());
    row.bind(2, news.reason);
    row.bind(3, news.whole ? 1 : 0);
    if (trial.submits) row.bind(4, Now_s());
    row.bind(5, news.person);
    row.bind(6, news.exercise);
    row.bind(7, news.n);
    row.exec();
  });
  trial.records = false;
  trial.news.submitted = trial.submits;
  return true;
} catch (const CourseHeld&) {  // nothing is lost: it is entered at a later poll
  return false;
} catch (const Error& error) {
  // A full disk may have space again.  The recording itself is kept.
  trial.trouble = error.what();
  if (std::exchange(trial.retry_ns, now_ns + kRetry_ns) != 0) return false;
  trial.news.whole = false;
  trial.news.reason += fmt::format("{}{}", trial.news.reason.empty() ? "" : "; ", error.what());
  spdlog::error("{}: {}", NameOf(trial.news), Printable(error.what()));
  Tell(trial, "unentered");
  return false;
}

void TrialRoom::Score(const News& kept, double length_s) {
  Running trial;
  trial.news = kept;
  trial.exercise = Find(kept.exercise);
  trial.most_s = std::max(length_s, trial.exercise->most_s);
  trials_.push_back(std::move(trial));
  Score(trials_.back());
}

void TrialRoom::ScoreLeftovers() {
  std::vector<std::pair<News, double>> leftovers;
  file_.Use([&](SQLite::Database& database) {
    SQLite::Statement rows(
        database,
        "SELECT person, exercise, n, IFNULL(reason, ''), whole, submitted_s, ended_s - begun_s "
        "FROM trials t WHERE "
        "ended_s IS NOT NULL AND passed IS NULL AND NOT EXISTS (SELECT 1 FROM exam_trials e WHERE "
        "e.person=t.person AND e.exercise=t.exercise AND e.n=t.n) ORDER BY ended_s");
    while (rows.executeStep()) {
      News news;
      news.person = rows.getColumn(0).getInt64();
      news.exercise = rows.getColumn(1).getString();
      news.n = rows.getColumn(2).getInt();
      news.reason = rows.getColumn(3).getString();
      news.whole = rows.getColumn(4).getInt() == 1;
      news.submitted = !rows.getColumn(5).isNull();
      leftovers.emplace_back(std::move(news), rows.getColumn(6).getDouble());
    }
  });
  for (auto& [news, length_s] : leftovers) {
    if (Find(news.exercise) == nullptr) continue;
    // A failed scoring is tried again: the disk may have been full.
    const std::size_t failed = news.reason.find(kNoScore);
    if (failed != news.reason.npos) news.reason.erase(failed < 2 ? 0 : failed - 2);
    Score(news, length_s);
  }
}

void TrialRoom::Score(Running& trial) {
  trial.cuts_short = trial.scorer && !trial.news.whole;
  trial.asked_ns = 0;
  if (trial.scorer) Tell(trial, "scoring");
}

double TrialRoom::MostToScore_s(const Running& trial) {
  // The time limit bounds the trial's length and the expert's.
  return kScore_s + kScorePerSecond * trial.most_s;
}

void TrialRoom::ScoreNext() {
  const auto waits = [](const Running& trial) { return !trial.records && !trial.scorer; };
  const auto at_work = std::ranges::count_if(
      trials_, [](const Running& trial) { return !trial.records && trial.scorer; });
  static const int most = std::min(UsableCores(), kMostFollowing);
  std::vector<Running*> queue;
  for (Running& trial : trials_) {
    if (!waits(trial)) continue;
    if (trial.place == 0) trial.place = ++places_;
    queue.push_back(&trial);
  }
  // Those whose person is waiting come first.
  std::ranges::sort(queue, {}, [](const Running* trial) {
    return std::pair(trial->news.holder == 0, trial->place);
  });
  auto ahead = static_cast<int>(at_work);
  for (Running* const trial : queue) {
    if (ahead < most) {
      BeginScoring(*trial, false);
      trial->asked_ns = 0;
      Tell(*trial, "scoring");
    } else if (trial->news.phase != "waiting" || trial->news.ahead != ahead) {
      trial->news.ahead = ahead;
      Tell(*trial, "waiting");
    }
    ++ahead;
  }
}

std::string TrialRoom::NameOf(std::int64_t person) {
  std::string name;
  try {
    file_.Use([&](SQLite::Database& database) {
      if (!database.tableExists("person")) return;
      SQLite::Statement row(database, "SELECT name FROM person WHERE id=?");
      row.bind(1, person);
      if (row.executeStep()) name = row.getColumn(0).getString();
    });
  } catch (const Error&) {
    // A score page without a name is better than no score.
  }
  return name;
}

std::string TrialRoom::NameOf(const News& news) {
  const std::string name = NameOf(news.person);
  return fmt::format("trial {} of '{}' by {}", news.n, news.exercise,
                     name.empty() ? fmt::format("person {}", news.person) : name);
}

void TrialRoom::BeginScoring(Running& trial, bool follows) {
  const std::string stem =
      fmt::format("{}/{}", FolderOf(trial.news.person, trial.news.exercise), trial.news.n);
  if (std::error_code none; fs::is_symlink(stem, none)) fs::remove(stem, none);  // nobody's report
  std::vector<std::string> arguments{"score",         trial.exercise->expert,
                                     stem + ".mcap",  "--criteria=" + trial.exercise->file,
                                     "--out=" + stem, "--join"};
  const std::string name = NameOf(trial.news.person);
  if (!name.empty()) arguments.push_back("--person=" + name);
  if (follows) arguments.emplace_back("--follow");
  trial.scorer =
      std::make_unique<ChildProgram>(options_.programs + "/palpate-replay", arguments,
                                     "what scores the trial", [&trial](const std::string& line) {
                                       if (line.starts_with("following ")) trial.follows = true;
                                     });
}

void TrialRoom::TakeScore(Running& trial) {
  News news = trial.news;  // a copy: while the course's file is held, it is tried again
  const std::string stem = fmt::format("{}/{}", FolderOf(news.person, news.exercise), news.n);
  std::string marks;
  try {
    if (trial.is_overdue) {
      throw Error(
          fmt::format("its scoring hung and was ended after {:.0f} s; the recording is kept, and "
                      "is scored again when the gateway is started anew",
                      MostToScore_s(trial)));
    }
    if (!trial.scorer->complaint().empty()) throw Error(trial.scorer->complaint());
    const Json score =
        Json::parse(ReadFileBelow(options_.folder, stem + "/score.json", kLargestScore));
    news.passed = score.at("passed");
    const Json& done = score.at("trials").at(0);
    if (!done.at("points").is_null()) news.points = done.at("points");
    marks = done.value("marks", Json::array()).dump();
    const auto lacks = [&](const std::string& what) {
      news.whole = false;
      news.reason += (news.reason.empty() ? "" : "; ") + what;
    };
    if (const int sessions = done.value("sessions", 1); sessions > 1) {
      // What the station did between two sessions is unknown.
      lacks("its station lost the server and came again, " +
            (sessions == 2 ? "once" : fmt::format("{} times", sessions - 1)));
    }
    if (const std::string why = done.value("incomplete", ""); !why.empty()) lacks(why);
    news.page = KeyOf(stem + "/score.html");
    file_.Use([&](SQLite::Database& database) {
      SQLite::Statement row(
          database,
          "UPDATE trials SET points=?, passed=?, marks=?, reason=?, whole=? WHERE person=? AND "
          "exercise=? AND n=?");
      if (news.points) row.bind(1, *news.points);
      row.bind(2, news.passed ? 1 : 0);
      row.bind(3, marks);
      row.bind(4, news.reason);
      row.bind(5, news.whole ? 1 : 0);
      row.bind(6, news.person);
      row.bind(7, news.exercise);
      row.bind(8, news.n);
      row.exec();
    });
    trial.news = news;
    Tell(trial, "scored");
  } catch (const CourseHeld&) {
    throw;
  } catch (const std::exception& error) {
    const std::string why = error.what();
    const std::string stored =
        fmt::format("{}{}{}{}", news.reason, news.reason.empty() ? "" : "; ", kNoScore, why);
    news.whole = news.whole && why.find(kSeveralSessions) == std::string::npos;
    // The page says itself that there is no score, and the person knows how an orderly trial ended.
    news.reason = news.whole || news.reason.empty() ? why : news.reason + "; " + why;
    file_.Use([&](SQLite::Database& database) {
      SQLite::Statement row(database,
                            "UPDATE trials SET whole=?, reason=? WHERE person=? AND exercise=? "
                            "AND n=?");
      row.bind(1, news.whole ? 1 : 0);
      row.bind(2, stored);
      row.bind(3, news.person);
      row.bind(4, news.exercise);
      row.bind(5, news.n);
      row.exec();
    });
    spdlog::error("{}: {}", NameOf(news), Printable(stored));
    trial.news = news;
    Tell(trial, "unscored");
  }
}

void TrialRoom::Poll(std::int64_t now_ns) {
  for (auto it = trials_.begin(); it != trials_.end();) {
    bool goes_on = false;
    try {
      goes_on = PollOne(*it, now_ns);
    } catch (const CourseHeld&) {
      goes_on = true;
    } catch (const Error& error) {
      it->news.whole = false;
      it->news.reason = error.what();
      Tell(*it, "unscored");
    }
    it = goes_on ? std::next(it) : trials_.erase(it);
  }
  try {
    ScoreNext();
  } catch (const Error&) {  // no process can be created now: the trial waits
  }
}

std::string TrialRoom::KeyOf(const std::string& page) {
  const auto known =
      std::ranges::find(pages_, page, [](const auto& entry) { return entry.second; });
  if (known != pages_.end()) return known->first;
  std::random_device random;
  std::string key;
  for (int i = 0; i < 4; ++i) key += fmt::format("{:08x}", random());
  return pages_.emplace(key, page).first->first;
}

std::map<std::pair<std::string, int>, std::string> TrialRoom::PagesOf(std::int64_t person) {
  std::map<std::pair<std::string, int>, std::string> pages;
  for (const TrialRow& row : ReadTrials(file_, person)) {
    const std::string page = fmt::format("{}/{}/score.html", FolderOf(person, row.exercise), row.n);
    std::error_code none;
    if (fs::exists(page, none)) pages[{row.exercise, row.n}] = KeyOf(page);
  }
  return pages;
}

void TrialRoom::ForgetPages(const std::set<std::int64_t>& people) {
  for (const std::int64_t person : people) {
    const std::string theirs = FolderOf(person, "");
    std::erase_if(pages_, [&](const auto& entry) { return entry.second.starts_with(theirs); });
  }
}

std::string TrialRoom::PageOf(const std::string& key) const {
  const auto page = pages_.find(key);
  return page == pages_.end() ? "" : page->second;
}

std::string TrialRoom::PictureOf(const std::string& path) const {
  for (const Exercise& exercise : exercises_) {
    for (const Exercise::Picture& picture : exercise.pictures) {
      if (exercise.name + "/" + picture.file == path) {
        return exercise.folder() + "/" + picture.file;
      }
    }
  }
  return "";
}

std::string TrialRoom::DescribeJson(const std::string& exercise) const {
  Json json = JsonOf(*Find(exercise));
  for (const char* hint : {"guide", "guards"}) json.erase(hint);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string TrialRoom::ListJson(std::int64_t person, bool teaches) {
  Json list = Json::array();
  for (const Exercise& exercise : exercises_) {
    list.push_back(JsonOf(exercise));
    if (teaches) list.back()["serve"] = ShellWord(exercise.scene);
  }
  file_.Use([&](SQLite::Database& database) {
    SQLite::Statement rows(database,
                           "SELECT exercise, n, points, passed, whole, submitted_s, reason FROM "
                           "trials WHERE person=? AND ended_s IS NOT NULL ORDER BY n");
    rows.bind(1, person);
    while (rows.executeStep()) {
      const std::string name = rows.getColumn(0).getString();
      const int n = rows.getColumn(1).getInt();
      const std::string page = fmt::format("{}/{}/score.html", FolderOf(person, name), n);
      std::error_code none;
      Json trial = {{"n", n},
                    {"points", nullptr},
                    {"passed", rows.getColumn(3).getInt() == 1},
                    {"whole", rows.getColumn(4).getInt() == 1},
                    {"submitted", !rows.getColumn(5).isNull()},
                    {"reason", rows.getColumn(6).getString()},
                    {"page", fs::exists(page, none) ? KeyOf(page) : ""}};
      if (!rows.getColumn(2).isNull()) trial["points"] = rows.getColumn(2).getDouble();
      for (Json& exercise : list) {
        if (exercise["name"] == name) exercise["done"].push_back(trial);
      }
    }
  });
  return Json({{"exercises", list}}).dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace palpate
