#pragma once

#include <string>
#include <vector>

#include "client/course/exercise.h"

namespace palpate {

/// One task of an exam: an exercise, without its hints.
struct ExamTask {
  std::string exercise;
  double time_s = 0.0;  ///< time limit of each trial
  int trials = 1;       ///< all of them count
  /// Of all from which a trial is graded: the exercise's file, its criteria's file, which may be
  /// the same file, and its expert's.
  std::string exercise_sha256, criteria_sha256, expert_sha256;

  bool operator==(const ExamTask&) const = default;
};

/// An exam: tasks that students do alone, in a fixed order and within a total time.  It is a file
/// in the course's folder that a teacher edits (exercises/README.md describes every field).
struct Exam {
  std::string name;    ///< file name without folder and ending
  std::string sha256;  ///< of the file
  LocalText title;
  std::vector<ExamTask> tasks;
  double time_s = 0.0;              ///< total time from the opening of the exam
  bool rotates = false;             ///< candidates begin at different scenes
  std::vector<std::string> people;  ///< names; empty: everybody with the role "drive"
};

inline constexpr const char* kExamEnding = ".exam.json";

/// Reads an exam and checks it with its exercises.  An exercise is looked up in the folder
/// `exercises` beside the exam, then among those shipped with the programs.  Throws Error
/// "file:line: field: what is wrong; remedy".
Exam LoadExam(const std::string& file);
/// Returns a task with the hashes of its exercise's files as they are now.  Throws Error.
ExamTask HashedTask(const Exercise& exercise);
/// Returns whether two tasks are graded from the same bytes.
bool SameFiles(const ExamTask& a, const ExamTask& b);
/// Returns the file of an exercise that an exam in that folder names; it need not exist.
std::string ExerciseFileOf(const std::string& folder, const std::string& exercise);
/// Returns the exam files of a course, sorted by name.
std::vector<std::string> ExamFiles(const std::string& folder);

}  // namespace palpate
