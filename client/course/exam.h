#pragma once

#include <string>
#include <vector>

#include "client/course/exercise.h"

namespace palpate {

/// One of an exam's tasks: an exercise, without its hints.
struct ExamTask {
  std::string exercise;
  double time_s = 0.0;  ///< of each trial
  int trials = 1;       ///< each of them counts
  /// Of the exercise's file, and of that of its criteria, which may be the same.
  std::string exercise_sha256, criteria_sha256;
};

/// What students do alone, in one order and within one time: a file that a teacher edits, in the
/// course's folder (exercises/README.md has every field).
struct Exam {
  std::string name;    ///< of its file, without folder and ending
  std::string sha256;  ///< of its file
  LocalText title;
  std::vector<ExamTask> tasks;
  double time_s = 0.0;              ///< in all, from when it is opened
  std::vector<std::string> people;  ///< names; none: all who drive
};

inline constexpr const char* kExamEnding = ".exam.json";

/// Reads an exam and checks all of it, its exercises too: those of the folder `exercises` beside
/// it, else those that come with the programs.  Throws Error "file:line: field: what is wrong;
/// remedy".
Exam LoadExam(const std::string& file);
/// The files of a course's exams, by their names.
std::vector<std::string> ExamFiles(const std::string& folder);

}  // namespace palpate
