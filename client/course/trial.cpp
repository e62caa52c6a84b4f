#include "client/course/trial.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "common/error.h"
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

}  // namespace

TrialRoom::TrialRoom(Options options, CourseFile& file, std::function<void(const News&)> tell)
    : options_(std::move(options)),
      lock_(options_.folder),
      table_(file),
      people_(file),
      pages_(options_.folder, table_),
      tell_(std::move(tell)) {
  for (const TrialRow& row : table_.EndLeftOver()) {
    spdlog::warn(
        "{} was interrupted when the gateway was killed; its recording lacks at most the last "
        "half second",
        NameOf(NewsOf(row)));
  }
}

int TrialRoom::Begin(Holder holder, std::int64_t person, const std::string& exercise,
                     const std::string& station, const std::string& scene, std::int64_t now_ns,
                     std::optional<double> exam_s) {
  Running trial;
  trial.exercise = pages_.Find(exercise);
  if (trial.exercise == nullptr) throw Error("there is no exercise " + Quoted(exercise));
  trials_.CheckMayBegin(person);
  trial.news.holder = holder;
  trial.news.person = person;
  trial.news.exercise = exercise;
  trial.scene = scene;
  trial.asked_ns = now_ns;
  trial.is_exam = trial.submits = exam_s.has_value();
  trial.most_s = exam_s.value_or(trial.exercise->most_s);
  const std::string folder = pages_.FolderOf(person, exercise);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw Error(folder + ": " + error.message() +
                "; cannot record there; check the folder's rights and the space on its disk");
  RefuseLinks(options_.folder, folder);
  trial.news.n = table_.Begin(person, exercise);
  std::vector<std::string> arguments{fmt::format("--output={}.mcap", StemOf(trial.news)),
                                     "--station=" + station, "--await-scene=" + scene};
  arguments.insert(arguments.end(), options_.network.begin(), options_.network.end());
  trials_.all.push_back(std::move(trial));
  Running& begun = trials_.all.back();
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
  for (Running& trial : trials_.all) {
    if (trial.news.holder != holder || trial.news.phase == "ending") continue;
    trial.news.whole = trial.news.whole && whole;
    BeginToEnd(trial, reason);
  }
}

void TrialRoom::Return(Holder holder, Holder to, std::int64_t now_ns) {
  for (Running& trial : trials_.all) {
    if (trial.news.holder != holder || trial.news.phase != "running") continue;
    trial.news.holder = to;
    trial.news.left_s = trial.most_s - 1e-9 * static_cast<double>(now_ns - trial.began_ns);
    Tell(trial, "running");
  }
}

void TrialRoom::EndOf(const std::set<std::int64_t>& people, const std::string& reason) {
  for (Running& trial : trials_.all) {
    if (people.contains(trial.news.person)) BeginToEnd(trial, reason);
  }
}

void TrialRoom::EndIn(const std::string& scene, const std::string& reason) {
  for (Running& trial : trials_.all) {
    if (!trial.records || trial.scene != scene) continue;
    trial.news.whole = false;
    BeginToEnd(trial, reason);
  }
}

void TrialRoom::Submit(Holder holder, std::int64_t person, const std::string& exercise, int n) {
  for (Running& trial : trials_.all) {
    if (!trial.records || trial.news.holder != holder || trial.news.exercise != exercise) continue;
    trial.submits = true;
    return BeginToEnd(trial, "submitted");
  }
  if (!table_.Submit({person, exercise, n})) throw Error("there is no such trial to submit");
}

void TrialRoom::Tell(Running& trial, const std::string& phase) {
  trial.news.phase = phase;
  tell_(trial.news);
  spdlog::info("{}: {}{}{}", NameOf(trial.news), trial.news.phase,
               trial.news.reason.empty() ? "" : ", ", trial.news.reason);
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
          trials_.all, [](const Running& other) { return other.records && other.scorer; });
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
  table_.End(news.key(), news.reason, news.whole, trial.submits);
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
  trial.exercise = pages_.Find(kept.exercise);
  trial.most_s = std::max(length_s, trial.exercise->most_s);
  trials_.all.push_back(std::move(trial));
  Score(trials_.all.back());
}

void TrialRoom::ScoreLeftovers() {
  for (const TrialRow& row : table_.Unscored()) {
    if (pages_.Find(row.exercise) == nullptr) continue;
    News news = NewsOf(row);
    // A failed scoring is tried again: the disk may have been full.
    const std::size_t failed = news.reason.find(kNoScore);
    if (failed != news.reason.npos) news.reason.erase(failed < 2 ? 0 : failed - 2);
    Score(news, static_cast<double>(row.ended_s - row.begun_s));
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
      trials_.all, [](const Running& trial) { return !trial.records && trial.scorer; });
  static const int most = std::min(UsableCores(), kMostFollowing);
  std::vector<Running*> queue;
  for (Running& trial : trials_.all) {
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

std::string TrialRoom::NameOf(const News& news) const {
  const std::string name = people_.NameOf(news.person);
  return fmt::format("trial {} of '{}' by {}", news.n, news.exercise,
                     name.empty() ? fmt::format("person {}", news.person) : name);
}

std::string TrialRoom::StemOf(const News& news) const {
  return fmt::format("{}/{}", pages_.FolderOf(news.person, news.exercise), news.n);
}

void TrialRoom::BeginScoring(Running& trial, bool follows) {
  const std::string stem = StemOf(trial.news);
  if (std::error_code none; fs::is_symlink(stem, none)) fs::remove(stem, none);  // nobody's report
  std::vector<std::string> arguments{"score",         trial.exercise->expert,
                                     stem + ".mcap",  "--criteria=" + trial.exercise->file,
                                     "--out=" + stem, "--join"};
  const std::string name = people_.NameOf(trial.news.person);
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
        Json::parse(ReadFileBelow(options_.folder, StemOf(news) + "/score.json", kLargestScore));
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
    news.page = pages_.KeyOf(news.key());
    table_.Score(news.key(), news.reason, news.whole, TrialScore{news.points, news.passed, marks});
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
    table_.Score(news.key(), stored, news.whole, std::nullopt);
    spdlog::error("{}: {}", NameOf(news), Printable(stored));
    trial.news = news;
    Tell(trial, "unscored");
  }
}

void TrialRoom::Poll(std::int64_t now_ns) {
  for (auto it = trials_.all.begin(); it != trials_.all.end();) {
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
    it = goes_on ? std::next(it) : trials_.all.erase(it);
  }
  try {
    ScoreNext();
  } catch (const Error&) {  // no process can be created now: the trial waits
  }
}

}  // namespace palpate
