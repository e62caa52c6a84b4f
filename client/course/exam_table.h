#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/course/course_file.h"
#include "client/course/exam.h"
#include "client/course/seal.h"
#include "client/course/trial_table.h"

namespace palpate {

/// An exam as stored in the table `exams`, with its candidates.
struct ExamRow {
  std::int64_t number = 0;  ///< 0: there is none
  Exam exam;                ///< without times and people of its file
  std::int64_t opened_s = 0, ends_s = 0, closed_s = 0, alive_s = 0, down_s = 0;
  std::set<std::int64_t> people;

  bool is_open() const { return number != 0 && closed_s == 0; }
};

/// A trial of an exam: its row in `exam_trials`, with that in `trials`.
struct ExamTrialRow : TrialRow {
  int task = 0;  ///< from 0
  std::string station, scene, scene_hash;
  bool counts = true;
};

/// A candidate's turn as stored in the table `exam_turns`.
struct TurnRow {
  std::int64_t person = 0;
  std::vector<int> tasks;
  std::int64_t place = 0, asked_s = 0, waited_s = 0;
};

/// The tables `exams`, `exam_people`, `exam_trials` and `exam_turns`.
/// Thread contract: as CourseFile.  Every function throws Error as CourseFile::Use does.
class ExamTable {
 public:
  /// A time of an exam that changes while it is open.
  enum class Time { kEnds, kClosed, kAlive, kDown };

  /// Creates the tables if they are missing.
  explicit ExamTable(CourseFile& file);

  /// Returns the newest exam.  Throws Error, too, if what stands there is none.
  ExamRow Newest() const;
  /// Returns the trials of an exam, by person, task and number.
  std::vector<ExamTrialRow> TrialsOf(std::int64_t exam) const;
  std::vector<TurnRow> TurnsOf(std::int64_t exam) const;

  /// Adds an exam that is opened.  Returns its number.
  std::int64_t Add(const Exam& exam, std::int64_t opened_s, std::int64_t ends_s);
  void AddPerson(std::int64_t exam, std::int64_t person);
  void Set(std::int64_t exam, Time time, std::int64_t value_s);
  /// Enters a trial that begins, as the roll does.
  void AddTrial(std::int64_t exam, const Roll::Entry& entry);
  /// The trial counts no more, for it is to be repeated.
  void DoesNotCount(const TrialKey& key);
  void DropTrial(const TrialKey& key);
  /// Stores a candidate's turn, but for an order of tasks that is there already.
  void Keep(std::int64_t exam, const TurnRow& turn);

 private:
  CourseFile& file_;
};

}  // namespace palpate
