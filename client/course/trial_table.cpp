#include "client/course/trial_table.h"

#include <ctime>

#include "client/course/sql.inl"

namespace palpate {
namespace {

std::int64_t Now_s() {
  return std::time(nullptr);
}

}  // namespace

const std::string kTrialColumns =
    "person, exercise, n, begun_s, ended_s, reason, whole, points, passed, marks, submitted_s";

TrialRow TrialRowOf(SQLite::Statement& row) {
  TrialRow trial;
  trial.person = row.getColumn(0).getInt64();
  trial.exercise = row.getColumn(1).getString();
  trial.n = row.getColumn(2).getInt();
  trial.begun_s = row.getColumn(3).getInt64();
  trial.ended_s = row.getColumn(4).getInt64();
  trial.reason = row.getColumn(5).getString();
  trial.whole = row.isColumnNull(6) ? trial.ended_s == 0 : row.getColumn(6).getInt() == 1;
  if (!row.isColumnNull(7)) trial.points = row.getColumn(7).getDouble();
  trial.scored = !row.isColumnNull(8);
  trial.passed = row.getColumn(8).getInt() == 1;
  trial.marks = row.getColumn(9).getString();
  if (!row.isColumnNull(10)) trial.submitted_s = row.getColumn(10).getInt64();
  return trial;
}

TrialTable::TrialTable(CourseFile& file) : file_(file) {
  Run(file_,
      "CREATE TABLE IF NOT EXISTS trials(person INTEGER NOT NULL, exercise TEXT NOT NULL, "
      "n INTEGER NOT NULL, begun_s INTEGER NOT NULL, ended_s INTEGER, reason TEXT, "
      "whole INTEGER, points REAL, passed INTEGER, marks TEXT, submitted_s INTEGER, seal TEXT, "
      "PRIMARY KEY(person, exercise, n))");
}

int TrialTable::Begin(std::int64_t person, const std::string& exercise) {
  return static_cast<int>(
      Rows(file_,
           "INSERT INTO trials(person, exercise, n, begun_s) SELECT ?1, ?2, IFNULL(MAX(n), 0) + 1, "
           "?3 FROM trials WHERE person=?1 AND exercise=?2 RETURNING n",
           NumberIn, person, exercise, Now_s())
          .front());
}

void TrialTable::End(const TrialKey& key, const std::string& reason, bool whole, bool submits) {
  Run(file_,
      "UPDATE trials SET ended_s=?, reason=?, whole=?, submitted_s=? WHERE person=? AND "
      "exercise=? AND n=?",
      Now_s(), reason, whole ? 1 : 0, submits ? std::optional(Now_s()) : std::nullopt, key.person,
      key.exercise, key.n);
}

std::vector<TrialRow> TrialTable::EndLeftOver() {
  return Rows(file_,
              "UPDATE trials SET ended_s=?, whole=0, reason='cut short: the gateway was killed' "
              "WHERE ended_s IS NULL RETURNING " +
                  kTrialColumns,
              TrialRowOf, Now_s());
}

bool TrialTable::Submit(const TrialKey& key) {
  return Run(file_,
             "UPDATE trials SET submitted_s=? WHERE person=? AND exercise=? AND n=? "
             "AND ended_s IS NOT NULL AND submitted_s IS NULL",
             Now_s(), key.person, key.exercise, key.n) == 1;
}

void TrialTable::Score(const TrialKey& key, const std::string& reason, bool whole,
                       const std::optional<TrialScore>& score) {
  using Marks = std::optional<std::string>;
  Run(file_,
      "UPDATE trials SET points=?, passed=?, marks=?, reason=?, whole=? WHERE person=? AND "
      "exercise=? AND n=?",
      score ? score->points : std::nullopt,
      score ? std::optional(score->passed ? 1 : 0) : std::nullopt,
      score ? Marks(score->marks) : Marks(), reason, whole ? 1 : 0, key.person, key.exercise,
      key.n);
}

void TrialTable::Seal(const TrialKey& key, const std::string& seal, const std::string& ended) {
  Run(file_,
      "UPDATE trials SET seal=?1, whole=IIF(?2='', whole, 0), reason=IIF(?2='', reason, ?2) "
      "WHERE person=?3 AND exercise=?4 AND n=?5",
      seal, ended, key.person, key.exercise, key.n);
}

std::vector<TrialRow> TrialTable::Ended(std::int64_t person) const {
  return Rows(file_,
              "SELECT " + kTrialColumns +
                  " FROM trials WHERE ended_s IS NOT NULL AND (?1 = 0 OR person = ?1) "
                  "ORDER BY person, exercise, n",
              TrialRowOf, person);
}

std::vector<TrialRow> TrialTable::Unscored() const {
  return Rows(file_,
              "SELECT " + kTrialColumns +
                  " FROM trials t WHERE ended_s IS NOT NULL AND passed IS NULL AND NOT EXISTS "
                  "(SELECT 1 FROM exam_trials e WHERE e.person=t.person AND e.exercise=t.exercise "
                  "AND e.n=t.n) ORDER BY ended_s",
              TrialRowOf);
}

}  // namespace palpate
