#pragma once

#include <cstdint>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "client/course/course_file.h"
#include "client/course/exam.h"
#include "client/course/exam_seals.h"
#include "client/course/exam_table.h"
#include "client/course/exam_turns.h"
#include "client/course/roster.h"
#include "client/course/trial.h"

namespace palpate {

/// The exam of a course, which a teacher opens and closes; at most one is open.  Its state is kept
/// in the course's file, so a restarted gateway continues it.  Each trial is sealed when it ends
/// and scored once the exam is closed.
/// Thread contract: one thread.  Seconds count from 1970.
class ExamRoom {
 public:
  /// A trial that a person begins.
  struct Beginning {
    TrialRoom::Holder holder = 0;
    std::int64_t person = 0;
    std::string exercise, station, scene;
    std::uint64_t scene_hash = 0;
  };

  /// Creates the tables, and continues an exam that was open.  Throws Error.
  ExamRoom(std::string folder, CourseFile& file, Roster& roster, TrialRoom& trials,
           std::int64_t now_s);
  ~ExamRoom();

  /// Carries out a command of a teacher's page.  Only these fields are accepted:
  ///   {"tag": 1, "op": "look"}                   reads the exam files again
  ///   {"tag": 2, "op": "open", "exam": NAME}
  ///   {"tag": 3, "op": "more", "s": SECONDS}     gives everybody more time
  ///   {"tag": 4, "op": "give_back"}              adds the time during which no gateway ran
  ///   {"tag": 5, "op": "again", "person": ID}    that person's last trial does not count
  ///   {"tag": 6, "op": "close"}
  /// Returns the answer for the page: {tag, refusal}.  Throws Error if it is no such command.
  std::string Do(std::string_view wish, std::int64_t now_s);

  /// Returns whether an exam is open that the person sits; the rest of the course is then
  /// closed to them.
  bool Sits(std::int64_t person) const;
  /// Returns whether the person sits the exam, or their trials are not yet on the roll or
  /// not yet scored.
  bool Needs(std::int64_t person) const;
  /// Reads the exam again if the person sits it: a trial of theirs has ended or was scored, or they
  /// were deleted.  Throws Error.
  void ReadOf(std::int64_t person);
  /// Returns the seat in which the person may begin the next task; empty: none is free, and the
  /// person waits in the queue from now on.  Throws Error, worded for the person, if that task has
  /// another exercise or the exam's time is over.
  /// @param seats  of those that it gives, the one in which a person last worked comes first.
  std::string SeatToBegin(std::int64_t person, const std::string& exercise, std::int64_t now_s,
                          const ExamTurns::Seats& seats);
  /// Gives free seats to who waits for them; to be called some times a second.
  void CallNext(std::int64_t now_s, const ExamTurns::Seats& seats);
  /// Returns whether a seat is kept for a candidate, who is to begin there.
  bool IsKept(const std::string& seat) const;
  /// Begins a trial of the next task.  Throws Error as SeatToBegin does.
  void Begin(const Beginning& beginning, std::int64_t now_s, std::int64_t now_ns);
  /// Ends all running trials of the exam, so that no trial time passes without a server.
  void EndTrials(const std::string& reason);
  /// Moves the exam's times with the computer's clock, which was set by so much [s]: nobody's time
  /// changes, and the teacher is told.
  void ClockWasSet(std::int64_t by_s);
  /// Marks, seals and scores; to be called some 100 times a second.  Returns whether pages
  /// must be updated.
  bool Poll(std::int64_t now_s);
  /// Returns the exam's state for a person's page; a teacher's page gets the state of all people.
  std::string StateJson(std::int64_t person, bool teaches, std::int64_t now_s) const;

 private:
  /// A trial with what the roll says of it.
  struct Trial : ExamTrialRow {
    bool sealed = false;
    std::string lost;    // why it cannot be sealed
    std::string sha256;  // of a sealed trial
  };

  void Read();
  /// Returns the index of the person's next task, from 0.  Throws Error as SeatToBegin does.
  std::size_t TaskToBegin(std::int64_t person, const std::string& exercise,
                          std::int64_t now_s) const;
  /// Returns where the person last worked in that scene; empty: nowhere.
  std::string LastSeatOf(std::int64_t person, const std::string& scene) const;
  bool Call(std::int64_t now_s, const ExamTurns::Seats& seats);
  /// Continues the exam that another process has left, as its roll says.
  void TakeUp(std::int64_t now_s);
  void Set(ExamTable::Time time, std::int64_t value_s);
  void SetEnd(std::int64_t ends_s);
  void Open(const std::string& name, std::int64_t now_s);
  void Store(const Exam& exam, const std::set<std::int64_t>& people, std::int64_t now_s);
  void Again(std::int64_t person);
  void Close(std::int64_t now_s);
  std::set<std::int64_t> PeopleOf(const Exam& exam) const;
  /// Returns the index of the person's task, from 0; the number of tasks if all are done.
  std::size_t TaskOf(std::int64_t person) const;
  /// Returns which of the person's tasks a task is, from 0, in the person's order.
  std::size_t PlaceOf(std::int64_t person, std::size_t task) const;
  /// Returns the task that the person does, or else the next one, as TaskOf.
  std::size_t PresentTaskOf(std::int64_t person) const;
  /// Returns the exercise of a task; null: there is no such task, or its file has gone.
  const Exercise* ExerciseOf(std::size_t task) const;
  std::string SceneOf(std::size_t task) const;
  std::string NextSceneOf(std::int64_t person) const { return SceneOf(TaskOf(person)); }
  /// Returns the person's running trial; null: none runs.
  const Trial* RunningOf(std::int64_t person) const;
  /// Returns for how long the person has waited for seats, and when their time is over.
  std::int64_t Waited_s(std::int64_t person, std::int64_t now_s) const;
  std::int64_t EndsFor_s(std::int64_t person, std::int64_t now_s) const;
  int DoneOf(std::int64_t person, std::size_t task) const;
  std::string NameOf(std::int64_t person) const;
  Roll NewRoll() const;
  /// @param trial  null: course.sqlite does not have it, though the roll does.
  Seal SealOf(const Roll::Entry& entry, const Trial* trial, std::int64_t now_s) const;
  void SealNext(std::int64_t now_s);
  void TakeSeal(const ExamSeals::Done& done);
  /// Tells the teacher what went wrong, which is tried again.
  void Stumble(const std::exception& error, std::int64_t now_s);
  /// Returns whether every trial of the exam is sealed, or cannot be.
  bool AllSettled() const;
  /// Returns whether the trial is still to be scored.
  bool Waits(const Trial& trial) const;
  void ScoreAll();
  /// Ends the roll of a closed exam whose trials are all settled.
  void CompleteRoll();
  /// Returns the reason why a trial ended early, neither by its person nor by a time limit; empty:
  /// it ended in order.
  static std::string CutOf(const Trial& trial);
  /// The newest exam's state: for a teacher, and for a person who sits it.
  std::string ClassJson(std::int64_t now_s) const;
  std::string OwnJson(std::int64_t person, std::int64_t now_s) const;
  /// Whether the person works, waits for a seat, or may begin: {phase, scene, seat, ahead, left_s,
  /// waits_s, waited_s}.
  std::string TurnJson(std::int64_t person, std::int64_t now_s) const;

  const std::string folder_;
  CourseFile& file_;
  Roster& roster_;
  TrialRoom& trials_;
  ExamTable table_;
  TrialTable trial_table_;
  ExamSeals seals_;
  ExamTurns turns_;
  ExamRow newest_;
  std::vector<Trial> done_;                          // trials of the newest exam, and running ones
  std::vector<std::pair<Exam, std::string>> exams_;  // with the error where a file cannot be read
  std::set<TrialKey> tried_;                         // trials whose scoring was tried
  std::string trouble_;                              // shown to the teacher
  std::int64_t retry_s_ = 0;
  std::int64_t set_by_s_ = 0;    // by how much the computer's clock was set; shown to the teacher
  std::int64_t owed_s_ = 0;      // of these, by which the exam's end is not moved yet
  std::set<std::int64_t> over_;  // those whose time is over
  bool changed_ = false;
};

}  // namespace palpate
