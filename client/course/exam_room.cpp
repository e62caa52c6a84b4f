#include "client/course/exam_room.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "common/error.h"
#include "common/json/json_file.h"
#include "common/text/hex16.h"
#include "common/text/lower_case.h"
#include "common/text/quoted.h"
#include "scenes/files/scene_file.h"

namespace palpate {

using Json = nlohmann::json;
namespace {

/// Interval [s] at which `alive_s` is stored, and so the accuracy of a killed gateway's time of
/// death; each write waits for the disk.
constexpr std::int64_t kBeat_s = 5;
constexpr std::int64_t kRetry_s = 10;  // a full disk may have space again
constexpr std::int64_t kMostMore_s = 8 * 3600;

constexpr const char* kTimeIsOver = "the exam's time is over";
constexpr const char* kClosed = "the exam is closed";

std::string Text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

ExamRoom::ExamRoom(std::string folder, CourseFile& file, Roster& roster, TrialRoom& trials,
                   std::int64_t now_s)
    : folder_(std::move(folder)),
      file_(file),
      roster_(roster),
      trials_(trials),
      table_(file),
      trial_table_(file),
      seals_(folder_),
      turns_(table_) {
  Read();
  Do(R"({"tag": 0, "op": "look"})", now_s);
  if (newest_.number != 0) TakeUp(now_s);
}

void ExamRoom::TakeUp(std::int64_t now_s) {
  seals_.TakeUp(NewRoll());
  if (!seals_.trouble().empty()) {
    spdlog::error("exam '{}': {}", newest_.exam.name, Printable(seals_.trouble()));
  } else {
    // What the roll does not have was never begun: its gateway was killed in that very moment, or
    // somebody wrote it into the file.
    for (const Trial& trial : done_) {
      if (seals_.Find(trial.key()) == nullptr) table_.DropTrial(trial.key());
    }
    Set(ExamTable::Time::kEnds, seals_.roll().ends_s);
    Set(ExamTable::Time::kClosed, seals_.roll().closed_s);
  }
  if (!newest_.is_open()) return;
  const std::int64_t down_s = now_s - newest_.alive_s;
  if (down_s > 2 * kBeat_s) {
    Set(ExamTable::Time::kDown, newest_.down_s + down_s);
    turns_.Move(down_s);  // it may be given back to all, so it is nobody's waiting
  }
  if (down_s < 0) ClockWasSet(down_s);  // or all would gain that time
  spdlog::warn(
      "exam '{}' is still open and continues; its clock ran on for the {} s without a gateway",
      newest_.exam.name, down_s);
}

ExamRoom::~ExamRoom() = default;

void ExamRoom::Read() {
  newest_ = {};
  done_.clear();
  changed_ = true;
  newest_ = table_.Newest();
  if (newest_.number == 0) return;
  turns_.Read(newest_.number, newest_.people, static_cast<int>(newest_.exam.tasks.size()));
  for (ExamTrialRow& row : table_.TrialsOf(newest_.number)) {
    Trial trial;
    static_cast<ExamTrialRow&>(trial) = std::move(row);
    if (const Roll::Entry* const entry = seals_.Find(trial.key())) {
      trial.counts = entry->counts;
      trial.sealed = !entry->seal.empty();
      trial.sha256 = entry->sha256;
      trial.lost = entry->lost;
    }
    done_.push_back(std::move(trial));
  }
}

void ExamRoom::Set(ExamTable::Time time, std::int64_t value_s) {
  table_.Set(newest_.number, time, value_s);
  Read();
}

void ExamRoom::SetEnd(std::int64_t ends_s) {
  if (seals_.trouble().empty()) {
    seals_.Change([&](Roll& roll) { roll.ends_s = ends_s; });
  }
  Set(ExamTable::Time::kEnds, ends_s);
  over_.clear();
}

// --- what a teacher does ---

std::string ExamRoom::Do(std::string_view wish, std::int64_t now_s) {
  const JsonNode json = JsonNode::Parse(wish, "/palpate/exam");
  const std::string op =
      json.At("op").OneOf({"look", "open", "more", "give_back", "again", "close"});
  const std::int64_t tag = json.At("tag").Integer(0, 0xffffffff);
  const auto number = [&](const char* field, std::int64_t most) {
    json.AllowOnly({"tag", "op", field});
    return json.At(field).Integer(1, most);
  };
  std::string refusal;
  try {
    if (op != "look" && op != "open" && !newest_.is_open()) throw Error("no exam is open");
    if (op == "look") {
      exams_.clear();
      for (const std::string& file : ExamFiles(folder_)) {
        try {
          exams_.emplace_back(LoadExam(file), "");
        } catch (const std::exception& error) {  // of any kind: the other exams are still listed
          Exam none;
          none.name = std::filesystem::path(file).filename().string();
          exams_.emplace_back(none, error.what());
        }
      }
      changed_ = true;
    } else if (op == "open") {
      json.AllowOnly({"tag", "op", "exam"});
      Open(json.At("exam").String(), now_s);
    } else if (op == "more") {
      SetEnd(std::max(newest_.ends_s, now_s) + number("s", kMostMore_s));
    } else if (op == "give_back") {
      SetEnd(newest_.ends_s + newest_.down_s);
      Set(ExamTable::Time::kDown, 0);
    } else if (op == "again") {
      Again(number("person", 0x7fffffff));
    } else {
      Close(now_s);
    }
    if (op != "look") spdlog::info("exam '{}': {}", newest_.exam.name, op);
  } catch (const std::exception& error) {
    refusal = error.what();
  }
  return Text({{"tag", tag}, {"refusal", refusal}});
}

std::set<std::int64_t> ExamRoom::PeopleOf(const Exam& exam) const {
  std::set<std::int64_t> people;
  for (const Person& person : roster_.people()) {
    if (exam.people.empty() && person.here() && person.role == Access::kDrive) {
      people.insert(person.id);
    }
  }
  for (const std::string& name : exam.people) {
    const Person* const found = roster_.FindName(name);
    if (found == nullptr || found->role != Access::kDrive) {
      const std::string near = roster_.NameNear(name);
      throw Error(
          fmt::format("people: no person with the role 'drive' is named {}; add that person under "
                      "Class, or edit the exam's file{}",
                      Quoted(name), near.empty() ? "" : ", where " + Quoted(near) + " is near"));
    }
    people.insert(found->id);
  }
  if (people.empty())
    throw Error("the course has no person with the role 'drive'; add people under Class");
  return people;
}

void ExamRoom::Store(const Exam& exam, const std::set<std::int64_t>& people,
                     std::int64_t now_s) try {
  Roll roll;
  roll.exam = exam.name;
  roll.exam_sha256 = exam.sha256;
  roll.tasks = exam.tasks;
  roll.opened_s = now_s;
  roll.ends_s = now_s + static_cast<std::int64_t>(exam.time_s);
  std::vector<std::string> scenes;
  for (const ExamTask& task : exam.tasks) {
    scenes.push_back(trials_.pages().Find(task.exercise)->scene_name);
  }
  file_.Whole([&] {
    roll.exam_number = table_.Add(exam, now_s, roll.ends_s);
    std::size_t n = 0;
    for (const std::int64_t person : people) {
      table_.AddPerson(roll.exam_number, person);
      table_.Keep(roll.exam_number, {person, ExamTurns::OrderOf(n++, exam.rotates, scenes)});
    }
    seals_.Open(roll);
  });
} catch (const Error&) {
  if (newest_.number != 0) seals_.TakeUp(NewRoll());  // the last exam's again
  throw;
}

void ExamRoom::Open(const std::string& name, std::int64_t now_s) {
  if (newest_.is_open()) {
    throw Error(fmt::format("exam '{}' is open; close it first", newest_.exam.name));
  }
  if (!AllSettled()) {
    throw Error("the last exam's trials are being sealed; wait a moment" +
                (trouble_.empty() ? "" : ": " + trouble_));
  }
  if (std::ranges::any_of(done_, [&](const Trial& trial) { return Waits(trial); })) {
    throw Error("the last exam's trials are being scored; wait a moment");
  }
  CompleteRoll();  // newest_ is about to be replaced
  if (!std::ranges::all_of(name, IsOfName)) throw Error("there is no exam " + Quoted(name));
  const Exam exam = LoadExam(folder_ + "/" + name + kExamEnding);
  for (const ExamTask& task : exam.tasks) {
    if (trials_.pages().Find(task.exercise) != nullptr) continue;
    throw Error(fmt::format(
        "exercise '{}' was added after this gateway started; restart the gateway", task.exercise));
  }
  const std::set<std::int64_t> people = PeopleOf(exam);
  Store(exam, people, now_s);
  Read();
  over_.clear();
  set_by_s_ = owed_s_ = 0;
  trials_.EndOf(people, "an exam begins");
  trials_.pages().Forget(people);
}

void ExamRoom::Again(std::int64_t person) {
  const auto last = std::ranges::max_element(done_, {}, [&](const Trial& trial) {
    // The task done last, from 1, and its last trial.
    return trial.person == person && trial.counts
               ? std::pair(PlaceOf(person, static_cast<std::size_t>(trial.task)) + 1, trial.n)
               : std::pair(std::size_t{0}, 0);
  });
  if (last == done_.end() || last->person != person || !last->counts) {
    throw Error("that person has no trial to repeat");
  }
  if (last->ended_s == 0)
    throw Error("that trial is still running; it can be repeated after it ends");
  seals_.Change(
      [&](Roll& roll) { std::ranges::find(roll.trials, last->key(), KeyOf)->counts = false; });
  table_.DoesNotCount(last->key());
  Read();
}

void ExamRoom::Close(std::int64_t now_s) {
  if (seals_.trouble().empty()) {
    seals_.Change([&](Roll& roll) { roll.closed_s = now_s; });
  }
  Set(ExamTable::Time::kClosed, now_s);
  trials_.EndOf(newest_.people, kClosed);
}

// --- what a student does ---

bool ExamRoom::Sits(std::int64_t person) const {
  return newest_.is_open() && newest_.people.contains(person);
}

bool ExamRoom::Needs(std::int64_t person) const {
  return newest_.people.contains(person) &&
         (newest_.is_open() || !(seals_.roll().complete || !seals_.trouble().empty()) ||
          std::ranges::any_of(
              done_, [&](const Trial& trial) { return trial.person == person && Waits(trial); }));
}

int ExamRoom::DoneOf(std::int64_t person, std::size_t task) const {
  return static_cast<int>(std::ranges::count_if(done_, [&](const Trial& trial) {
    return trial.person == person && trial.counts && trial.task == static_cast<int>(task);
  }));
}

std::size_t ExamRoom::TaskOf(std::int64_t person) const {
  for (const int at : turns_.Of(person).tasks) {
    const auto task = static_cast<std::size_t>(at);
    if (DoneOf(person, task) < newest_.exam.tasks.at(task).trials) return task;
  }
  return newest_.exam.tasks.size();
}

std::size_t ExamRoom::PlaceOf(std::int64_t person, std::size_t task) const {
  const std::vector<int>& order = turns_.Of(person).tasks;
  return static_cast<std::size_t>(std::ranges::find(order, static_cast<int>(task)) - order.begin());
}

const Exercise* ExamRoom::ExerciseOf(std::size_t task) const {
  return task < newest_.exam.tasks.size() ? trials_.pages().Find(newest_.exam.tasks[task].exercise)
                                          : nullptr;
}

std::string ExamRoom::SceneOf(std::size_t task) const {
  const Exercise* const exercise = ExerciseOf(task);
  return exercise == nullptr ? "" : exercise->scene_name;
}

std::size_t ExamRoom::PresentTaskOf(std::int64_t person) const {
  const Trial* const runs = RunningOf(person);
  return runs == nullptr ? TaskOf(person) : static_cast<std::size_t>(runs->task);
}

const ExamRoom::Trial* ExamRoom::RunningOf(std::int64_t person) const {
  const auto runs = std::ranges::find_if(done_, [&](const Trial& trial) {
    return trial.person == person && trial.counts && trial.ended_s == 0;
  });
  return runs == done_.end() ? nullptr : &*runs;
}

std::int64_t ExamRoom::Waited_s(std::int64_t person, std::int64_t now_s) const {
  const ExamTurns::Turn& turn = turns_.Of(person);
  std::int64_t waited_s = turn.waited_s + turn.WaitsFor_s(now_s);
  for (const Roll::Entry& entry : seals_.roll().trials) {
    if (entry.person == person) waited_s += entry.waited_s;
  }
  return waited_s;
}

std::int64_t ExamRoom::EndsFor_s(std::int64_t person, std::int64_t now_s) const {
  return newest_.ends_s + owed_s_ + Waited_s(person, now_s);
}

bool ExamRoom::Call(std::int64_t now_s, const ExamTurns::Seats& seats) {
  const ExamTurns::Seats last_first{[&](std::int64_t person, const std::string& scene) {
                                      std::vector<std::string> free = seats.free(person, scene);
                                      const auto last =
                                          std::ranges::find(free, LastSeatOf(person, scene));
                                      if (last != free.end())
                                        std::rotate(free.begin(), last, last + 1);
                                      return free;
                                    },
                                    seats.is_here};
  return turns_.Call(now_s, last_first, [this](std::int64_t of) { return NextSceneOf(of); });
}

std::string ExamRoom::SeatToBegin(std::int64_t person, const std::string& exercise,
                                  std::int64_t now_s, const ExamTurns::Seats& seats) {
  TaskToBegin(person, exercise, now_s);
  turns_.Ask(person, now_s);
  Call(now_s, seats);
  changed_ = true;
  return turns_.Of(person).seat;
}

void ExamRoom::CallNext(std::int64_t now_s, const ExamTurns::Seats& seats) {
  if (!newest_.is_open() || now_s < retry_s_) return;
  try {
    changed_ = Call(now_s, seats) || changed_;
  } catch (const CourseHeld&) {  // it is tried again
  } catch (const Error& error) {
    Stumble(error, now_s);
  }
}

bool ExamRoom::IsKept(const std::string& seat) const {
  return newest_.is_open() && turns_.IsKept(seat);
}

std::string ExamRoom::LastSeatOf(std::int64_t person, const std::string& scene) const {
  std::string seat;
  std::int64_t begun_s = 0;
  for (const Trial& trial : done_) {
    if (trial.person != person || trial.begun_s < begun_s ||
        SceneOf(static_cast<std::size_t>(trial.task)) != scene) {
      continue;
    }
    seat = trial.scene;
    begun_s = trial.begun_s;
  }
  return seat;
}

std::size_t ExamRoom::TaskToBegin(std::int64_t person, const std::string& exercise,
                                  std::int64_t now_s) const {
  if (!seals_.trouble().empty()) {
    throw Error(
        "this exam can go on no more, because its roll is not in order; tell your examiner");
  }
  const std::size_t at = TaskOf(person);
  if (at == newest_.exam.tasks.size()) throw Error("you have done all of the exam's tasks");
  if (exercise != newest_.exam.tasks[at].exercise) throw Error("this is not the exam's next task");
  if (now_s >= EndsFor_s(person, now_s)) throw Error(kTimeIsOver);
  return at;
}

void ExamRoom::Begin(const Beginning& of, std::int64_t now_s, std::int64_t now_ns) {
  const std::size_t at = TaskToBegin(of.person, of.exercise, now_s);
  const ExamTask& task = newest_.exam.tasks[at];
  const int n =
      trials_.Begin(of.holder, of.person, of.exercise, of.station, of.scene, now_ns, task.time_s);
  try {
    Roll::Entry entry;
    entry.person = of.person;
    entry.name = NameOf(of.person);
    entry.task = static_cast<int>(at) + 1;
    entry.exercise = of.exercise;
    entry.n = n;
    entry.station = of.station;
    entry.scene = of.scene;
    entry.scene_hash = Hex16(of.scene_hash);
    entry.begun_s = now_s;
    const ExamTurns::Turn& turn = turns_.Of(of.person);
    entry.waited_s = turn.waited_s + turn.WaitsFor_s(now_s);
    file_.Whole([&] {
      table_.AddTrial(newest_.number, entry);
      turns_.Begin(of.person);
      seals_.Begin(entry, now_s);
    });
    turns_.Begun(of.person);
  } catch (const Error&) {
    trials_.End(of.holder, "the exam's file cannot be written");
    throw;
  }
  Read();
}

void ExamRoom::EndTrials(const std::string& reason) {
  if (newest_.is_open()) trials_.EndOf(newest_.people, reason);
}

void ExamRoom::ClockWasSet(std::int64_t by_s) {
  if (!newest_.is_open()) return;
  spdlog::warn("exam '{}': the computer's clock was set by {:+} s; nobody's time changes",
               newest_.exam.name, by_s);
  set_by_s_ += by_s;
  owed_s_ += by_s;
  turns_.Move(by_s);
  newest_.alive_s += by_s;
  changed_ = true;
}

void ExamRoom::ReadOf(std::int64_t person) {
  if (newest_.people.contains(person)) Read();
}

// --- sealing and scoring ---

std::string ExamRoom::NameOf(std::int64_t person) const {
  const auto found = std::ranges::find(roster_.people(), person, &Person::id);
  return found == roster_.people().end() ? "" : found->name;
}

Roll ExamRoom::NewRoll() const {
  Roll roll;
  roll.exam = newest_.exam.name;
  roll.exam_number = newest_.number;
  roll.exam_sha256 = newest_.exam.sha256;
  roll.tasks = newest_.exam.tasks;
  roll.opened_s = newest_.opened_s;
  roll.ends_s = newest_.ends_s;
  roll.closed_s = newest_.closed_s;
  return roll;
}

Seal ExamRoom::SealOf(const Roll::Entry& entry, const Trial* trial, std::int64_t now_s) const {
  const ExamTask& task = seals_.roll().tasks.at(static_cast<std::size_t>(entry.task - 1));
  Seal seal;
  seal.recording = fmt::format("trials/{}/{}/{}.mcap", entry.person, entry.exercise, entry.n);
  seal.person = entry.person;
  seal.name = entry.name;
  seal.station = entry.station;
  seal.scene = entry.scene;
  seal.scene_hash = entry.scene_hash;
  seal.exam = newest_.exam.name;
  seal.exam_number = newest_.number;
  seal.exam_sha256 = newest_.exam.sha256;
  seal.task = entry.task;
  seal.exercise = entry.exercise;
  seal.n = entry.n;
  seal.exercise_sha256 = task.exercise_sha256;
  seal.criteria_sha256 = task.criteria_sha256;
  seal.expert_sha256 = task.expert_sha256;
  seal.begun_s = entry.begun_s;
  seal.sealed_s = now_s;
  if (trial == nullptr) {
    seal.whole = false;
    seal.reason = "its end could not be stored";
    return seal;
  }
  seal.ended_s = trial->ended_s;
  seal.whole = trial->whole;
  seal.reason = Printable(trial->reason);
  return seal;
}

bool ExamRoom::AllSettled() const {
  return std::ranges::all_of(seals_.roll().trials, &Roll::Entry::is_settled);
}

void ExamRoom::SealNext(std::int64_t now_s) {
  if (now_s < retry_s_ || !seals_.is_idle()) return;
  for (const Roll::Entry& entry : seals_.roll().trials) {
    if (entry.is_settled()) continue;
    const auto trial = std::ranges::find(done_, KeyOf(entry), &Trial::key);
    const bool is_known = trial != done_.end();
    if (is_known ? trial->ended_s == 0 : trials_.now().Has(KeyOf(entry))) {
      continue;
    }
    return seals_.BeginToSeal(SealOf(entry, is_known ? &*trial : nullptr, now_s));
  }
}

void ExamRoom::TakeSeal(const ExamSeals::Done& done) {
  trial_table_.Seal(done.key, done.text, done.is_rest ? ExamSeals::kKilled : "");
  trouble_.clear();
  Read();
}

bool ExamRoom::Waits(const Trial& trial) const {
  return !trial.scored && !trial.sha256.empty() &&
         (!tried_.contains(trial.key()) || trials_.now().Has(trial.key()));
}

void ExamRoom::ScoreAll() {
  // Score's news reloads done_.
  std::vector<std::pair<TrialRoom::News, double>> all;
  for (const Trial& trial : done_) {
    if (!Waits(trial) || !tried_.insert(trial.key()).second) continue;
    const ExamTask& task = newest_.exam.tasks.at(static_cast<std::size_t>(trial.task));
    const Exercise* const exercise = trials_.pages().Find(trial.exercise);
    if (exercise == nullptr || !SameFiles(HashedTask(*exercise), task)) {
      trouble_ = fmt::format(
          "'{}' is not scored, because its file, that of its criteria or its expert's was changed "
          "after the exam was opened; restore that file, and restart the gateway",
          trial.exercise);
      changed_ = true;
      continue;
    }
    TrialRoom::News kept = NewsOf(trial);
    kept.submitted = true;
    all.emplace_back(std::move(kept), static_cast<double>(trial.ended_s - trial.begun_s));
  }
  for (const auto& [kept, length_s] : all) trials_.Score(kept, length_s);
}

void ExamRoom::CompleteRoll() {
  if (newest_.closed_s == 0 || seals_.roll().complete || !seals_.trouble().empty()) return;
  seals_.Change([](Roll& roll) { roll.complete = true; });
}

bool ExamRoom::Poll(std::int64_t now_s) {
  try {
    if (newest_.is_open()) {
      if (owed_s_ != 0) {
        SetEnd(newest_.ends_s + owed_s_);
        Set(ExamTable::Time::kAlive, now_s);
        owed_s_ = 0;
      }
      if (now_s >= newest_.alive_s + kBeat_s && now_s >= retry_s_) {
        table_.Set(newest_.number, ExamTable::Time::kAlive, now_s);
        newest_.alive_s = now_s;
      }
      std::set<std::int64_t> ending;  // first, because an end may read the exam anew
      for (const std::int64_t person : newest_.people) {
        if (now_s >= EndsFor_s(person, now_s) && over_.insert(person).second) ending.insert(person);
      }
      if (!ending.empty()) {
        trials_.EndOf(ending, kTimeIsOver);
        changed_ = true;
      }
    }
    if (const auto done = seals_.Take()) TakeSeal(*done);
    seals_.Poll(now_s);
    SealNext(now_s);
    if (newest_.closed_s != 0 && AllSettled() && now_s >= retry_s_) {
      CompleteRoll();
      ScoreAll();
    }
  } catch (const std::exception& error) {
    Stumble(error, now_s);
  }
  return std::exchange(changed_, false);
}

void ExamRoom::Stumble(const std::exception& error, std::int64_t now_s) {
  if (trouble_ != error.what()) spdlog::error("exam '{}': {}", newest_.exam.name, error.what());
  trouble_ = error.what();
  retry_s_ = now_s + kRetry_s;
  changed_ = true;
}

// --- what pages are told ---

std::string ExamRoom::CutOf(const Trial& trial) {
  static const std::set<std::string> kInOrder = {"submitted", "stopped", "the time is over",
                                                 kTimeIsOver, kClosed};
  if (!trial.lost.empty()) return trial.lost;
  // Why there are no points, after it, is of no use to who reads that it was cut short.
  const std::string ended = trial.reason.substr(0, trial.reason.find("; no score: "));
  return trial.ended_s != 0 && (!trial.whole || !kInOrder.contains(ended)) ? ended : "";
}

std::string ExamRoom::TurnJson(std::int64_t person, std::int64_t now_s) const {
  const ExamTurns::Turn& turn = turns_.Of(person);
  const Trial* const runs = RunningOf(person);
  const std::size_t task = PresentTaskOf(person);
  const auto scene_of = [this](std::int64_t of) { return NextSceneOf(of); };
  const char* const phase = runs                                ? "works"
                            : task == newest_.exam.tasks.size() ? "done"
                            : turn.waits()                      ? "waits"
                            : turn.place != 0                   ? "called"
                                                                : "ready";
  return Text({{"phase", phase},
               {"scene", SceneOf(task)},
               {"seat", runs ? runs->scene : turn.seat},
               {"ahead", turn.waits() ? turns_.AheadOf(person, scene_of) : 0},
               {"left_s", turn.seat.empty() ? 0 : std::max<std::int64_t>(0, turn.until_s - now_s)},
               {"waits_s", turn.WaitsFor_s(now_s)},
               {"waited_s", Waited_s(person, now_s)}});
}

std::string ExamRoom::ClassJson(std::int64_t now_s) const {
  Json json = {{"down_s", newest_.down_s}, {"set_by_s", set_by_s_}, {"people", Json::array()}};
  for (const std::int64_t person : newest_.people) {
    Json trials = Json::array();
    for (const Trial& trial : done_) {
      if (trial.person != person) continue;
      trials.push_back({{"task", trial.task},
                        {"counts", trial.counts},
                        {"running", trial.ended_s == 0},
                        {"cut", CutOf(trial)},
                        {"sealed", trial.sealed},
                        {"lost", trial.lost},
                        {"scored", trial.scored},
                        {"points", trial.points ? Json(*trial.points) : Json()}});
    }
    const std::size_t task = PresentTaskOf(person);
    const Exercise* const exercise = ExerciseOf(task);
    json["people"].push_back({{"person", person},
                              {"name", NameOf(person)},
                              {"task", task},
                              {"title", Json(exercise ? exercise->title : LocalText())},
                              {"turn", Json::parse(TurnJson(person, now_s))},
                              {"trials", trials}});
  }
  return Text(json);
}

std::string ExamRoom::OwnJson(std::int64_t person, std::int64_t now_s) const {
  Json json;
  json["cut"] = "";
  std::pair<std::size_t, int> newest;  // the task's place and the trial's number
  for (const Trial& trial : done_) {
    if (trial.person != person || !trial.counts) continue;
    const std::pair at(PlaceOf(person, static_cast<std::size_t>(trial.task)), trial.n);
    if (at < newest) continue;
    newest = at;
    json["cut"] = CutOf(trial);
  }
  const std::size_t at = PresentTaskOf(person);
  json["task"] = PlaceOf(person, at);
  json["turn"] = Json::parse(TurnJson(person, now_s));
  json["turn"]["works"] = Json::array();
  if (at == newest_.exam.tasks.size()) return Text(json);
  for (const std::int64_t other : newest_.people) {
    const bool is_there = RunningOf(other) && SceneOf(PresentTaskOf(other)) == SceneOf(at);
    if (other != person && is_there) json["turn"]["works"].push_back(NameOf(other));
  }
  const ExamTask& task = newest_.exam.tasks[at];
  json["trial"] = DoneOf(person, at) + (RunningOf(person) ? 0 : 1);
  json["trials"] = task.trials;
  json["time_s"] = task.time_s;
  json["exercise"] = Json::parse(trials_.pages().DescribeJson(task.exercise));
  return Text(json);
}

std::string ExamRoom::StateJson(std::int64_t person, bool teaches, std::int64_t now_s) const {
  Json json = {{"open", nullptr}};
  if (newest_.number != 0 && (teaches || Sits(person))) {
    Json& open = json["open"];
    open = {
        {"name", newest_.exam.name},
        {"title", Json(newest_.exam.title)},
        {"closed", !newest_.is_open()},
        {"left_s", std::max<std::int64_t>(
                       0, (teaches ? newest_.ends_s + owed_s_ : EndsFor_s(person, now_s)) - now_s)},
        {"tasks", newest_.exam.tasks.size()}};
    open.update(Json::parse(teaches ? ClassJson(now_s) : OwnJson(person, now_s)));
  }
  if (teaches) {
    json["exams"] = Json::array();
    for (const auto& [exam, wrong] : exams_) {
      json["exams"].push_back({{"name", exam.name},
                               {"title", Json(exam.title)},
                               {"tasks", exam.tasks.size()},
                               {"time_s", exam.time_s},
                               {"wrong", wrong}});
    }
    json["trouble"] = seals_.trouble().empty() ? trouble_ : seals_.trouble();
  }
  return Text(json);
}

}  // namespace palpate
