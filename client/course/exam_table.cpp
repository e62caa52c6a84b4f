#include "client/course/exam_table.h"

#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "client/course/sql.inl"
#include "common/error.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr const char* kTables = R"(CREATE TABLE IF NOT EXISTS exams(
  id INTEGER PRIMARY KEY AUTOINCREMENT, name TEXT NOT NULL, sha256 TEXT NOT NULL,
  title TEXT NOT NULL, tasks TEXT NOT NULL, opened_s INTEGER NOT NULL, ends_s INTEGER NOT NULL,
  closed_s INTEGER NOT NULL DEFAULT 0, alive_s INTEGER NOT NULL, down_s INTEGER NOT NULL DEFAULT 0);
CREATE TABLE IF NOT EXISTS exam_people(
  exam INTEGER NOT NULL, person INTEGER NOT NULL, PRIMARY KEY(exam, person));
CREATE TABLE IF NOT EXISTS exam_trials(
  exam INTEGER NOT NULL, person INTEGER NOT NULL, task INTEGER NOT NULL, exercise TEXT NOT NULL,
  n INTEGER NOT NULL, station TEXT NOT NULL, scene TEXT NOT NULL, scene_hash TEXT NOT NULL,
  counts INTEGER NOT NULL DEFAULT 1, PRIMARY KEY(person, exercise, n));
CREATE TABLE IF NOT EXISTS exam_turns(
  exam INTEGER NOT NULL, person INTEGER NOT NULL, tasks TEXT NOT NULL,
  place INTEGER NOT NULL DEFAULT 0, asked_s INTEGER NOT NULL DEFAULT 0,
  waited_s INTEGER NOT NULL DEFAULT 0, PRIMARY KEY(exam, person)))";

[[noreturn]] void Refuse(std::int64_t exam, const Json::exception& error) {
  throw Error(
      fmt::format("course.sqlite: exam {}: {}; it was changed by hand; restore it from a copy",
                  exam, error.what()));
}

ExamRow ExamOf(SQLite::Statement& row) {
  ExamRow exam;
  exam.number = NumberIn(row);
  exam.exam.name = row.getColumn(1).getString();
  exam.exam.sha256 = row.getColumn(2).getString();
  try {
    exam.exam.title = Json::parse(row.getColumn(3).getString()).get<LocalText>();
    exam.exam.tasks = ReadTasks(row.getColumn(4).getString());
  } catch (const Json::exception& error) {
    Refuse(exam.number, error);
  }
  exam.opened_s = row.getColumn(5).getInt64();
  exam.ends_s = row.getColumn(6).getInt64();
  exam.closed_s = row.getColumn(7).getInt64();
  exam.alive_s = row.getColumn(8).getInt64();
  exam.down_s = row.getColumn(9).getInt64();
  return exam;
}

ExamTrialRow TrialOf(SQLite::Statement& row) {
  ExamTrialRow trial;
  static_cast<TrialRow&>(trial) = TrialRowOf(row);
  int at = kTrialColumnCount;
  trial.task = row.getColumn(at++).getInt();
  trial.station = row.getColumn(at++).getString();
  trial.scene = row.getColumn(at++).getString();
  trial.scene_hash = row.getColumn(at++).getString();
  trial.counts = row.getColumn(at++).getInt() == 1;
  return trial;
}

TurnRow TurnOf(SQLite::Statement& row) {
  return {NumberIn(row), Json::parse(row.getColumn(1).getString()).get<std::vector<int>>(),
          row.getColumn(2).getInt64(), row.getColumn(3).getInt64(), row.getColumn(4).getInt64()};
}

}  // namespace

ExamTable::ExamTable(CourseFile& file) : file_(file) {
  file_.Use([](SQLite::Database& database) { database.exec(kTables); });
}

ExamRow ExamTable::Newest() const {
  auto exams = Rows(file_,
                    "SELECT id, name, sha256, title, tasks, opened_s, ends_s, closed_s, "
                    "alive_s, down_s FROM exams ORDER BY id DESC LIMIT 1",
                    ExamOf);
  if (exams.empty()) return {};
  const auto people =
      Rows(file_, "SELECT person FROM exam_people WHERE exam=?", NumberIn, exams.front().number);
  exams.front().people = {people.begin(), people.end()};
  return std::move(exams.front());
}

std::vector<ExamTrialRow> ExamTable::TrialsOf(std::int64_t exam) const {
  return Rows(file_,
              "SELECT " + kTrialColumns +
                  ", task, station, scene, scene_hash, counts FROM exam_trials JOIN trials "
                  "USING(person, exercise, n) WHERE exam=? ORDER BY person, task, n",
              TrialOf, exam);
}

std::vector<TurnRow> ExamTable::TurnsOf(std::int64_t exam) const try {
  return Rows(file_, "SELECT person, tasks, place, asked_s, waited_s FROM exam_turns WHERE exam=?",
              TurnOf, exam);
} catch (const Json::exception& error) {
  Refuse(exam, error);
}

std::int64_t ExamTable::Add(const Exam& exam, std::int64_t opened_s, std::int64_t ends_s) {
  return Rows(file_,
              "INSERT INTO exams(name, sha256, title, tasks, opened_s, ends_s, alive_s) "
              "VALUES(?, ?, ?, ?, ?, ?, ?) RETURNING id",
              NumberIn, exam.name, exam.sha256, Json(exam.title).dump(), TasksText(exam.tasks),
              opened_s, ends_s, opened_s)
      .front();
}

void ExamTable::AddPerson(std::int64_t exam, std::int64_t person) {
  Run(file_, "INSERT INTO exam_people(exam, person) VALUES(?, ?)", exam, person);
}

void ExamTable::Set(std::int64_t exam, Time time, std::int64_t value_s) {
  constexpr std::array kColumns = {"ends_s", "closed_s", "alive_s", "down_s"};
  Run(file_,
      fmt::format("UPDATE exams SET {}=? WHERE id=?", kColumns.at(static_cast<std::size_t>(time))),
      value_s, exam);
}

void ExamTable::AddTrial(std::int64_t exam, const Roll::Entry& entry) {
  Run(file_,
      "INSERT INTO exam_trials(exam, person, task, exercise, n, station, scene, scene_hash) "
      "VALUES(?, ?, ?, ?, ?, ?, ?, ?)",
      exam, entry.person, entry.task - 1, entry.exercise, entry.n, entry.station, entry.scene,
      entry.scene_hash);
}

void ExamTable::DoesNotCount(const TrialKey& key) {
  Run(file_, "UPDATE exam_trials SET counts=0 WHERE person=? AND exercise=? AND n=?", key.person,
      key.exercise, key.n);
}

void ExamTable::DropTrial(const TrialKey& key) {
  Run(file_, "DELETE FROM exam_trials WHERE person=? AND exercise=? AND n=?", key.person,
      key.exercise, key.n);
}

void ExamTable::Keep(std::int64_t exam, const TurnRow& turn) {
  Run(file_,
      "INSERT INTO exam_turns(exam, person, tasks, place, asked_s, waited_s) VALUES(?, ?, ?, ?, "
      "?, ?) ON CONFLICT(exam, person) DO UPDATE SET place=excluded.place, "
      "asked_s=excluded.asked_s, waited_s=excluded.waited_s",
      exam, turn.person, Json(turn.tasks).dump(), turn.place, turn.asked_s, turn.waited_s);
}

}  // namespace palpate
