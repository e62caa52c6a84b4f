#pragma once

#include <cstdint>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "client/course/course_file.h"
#include "client/course/exam.h"
#include "client/course/roster.h"
#include "client/course/seal.h"
#include "client/course/trial.h"

namespace palpate {

/// The exam of a course: opened and closed by a teacher, one at a time.  Its state is in the
/// course's file, so that a gateway that was killed goes on with it.  What was handed in is sealed;
/// it is scored once the exam is closed.
/// Thread contract: one thread.  Seconds are those since 1970.
class ExamRoom {
 public:
  /// A trial that somebody begins.
  struct Beginning {
    TrialRoom::Holder holder = 0;
    std::int64_t person = 0;
    std::string exercise, station, scene;
    std::uint64_t scene_hash = 0;
  };

  /// Makes its tables, and goes on with an exam that was open.  Throws Error.
  ExamRoom(std::string folder, CourseFile& file, Roster& roster, TrialRoom& trials,
           std::int64_t now_s);
  ~ExamRoom();

  /// What a teacher's page wants, these fields and no others:
  ///   {"tag": 1, "op": "look"}                   reads the exams' files again
  ///   {"tag": 2, "op": "open", "exam": NAME}
  ///   {"tag": 3, "op": "more", "s": SECONDS}     gives all more time
  ///   {"tag": 4, "op": "give_back"}              and what went by while there was no gateway
  ///   {"tag": 5, "op": "again", "person": ID}    the last trial of that person does not count
  ///   {"tag": 6, "op": "close"}
  /// Returns what the page is answered: {tag, refusal}.  Throws Error for what is none of these.
  std::string Do(std::string_view wish, std::int64_t now_s);

  /// An exam is open, and theirs: all else of the course is closed to them.
  bool Sits(std::int64_t person) const;
  /// They do, or what they handed in is not on the roll yet, or not scored.
  bool Needs(std::int64_t person) const;
  /// Somebody was deleted.  Throws Error.
  void Read();
  /// The number of the next task, from 0.  Throws Error, for the person, where the exercise is not
  /// that task's, or the time is over.
  std::size_t TaskToBegin(std::int64_t person, const std::string& exercise,
                          std::int64_t now_s) const;
  /// Throws Error, as that does.
  void Begin(const Beginning& beginning, std::int64_t now_s, std::int64_t now_ns);
  /// Where there is no server any more: nobody's time is to run without one.
  void EndTrials(const std::string& reason);
  /// A trial has ended, or was scored.
  void Heard(const TrialRoom::News& news);
  /// Seals and scores, some 100 times a second.  True where pages are to be told anew.
  bool Poll(std::int64_t now_s);
  /// For a person's page; who teaches hears of all.
  std::string StateJson(std::int64_t person, bool teaches, std::int64_t now_s) const;

 private:
  struct Trial {
    std::int64_t person = 0;
    int task = 0;  // from 0
    std::string exercise;
    int n = 0;
    std::string station, scene, scene_hash;
    bool counts = true;
    std::int64_t begun_s = 0, ended_s = 0;  // 0: runs
    bool whole = true;
    std::string reason;
    bool sealed = false;
    bool scored = false;  // a trial in which nothing is touched has no points
    std::optional<double> points;
    std::string sha256;  // of a sealed one
    std::tuple<std::int64_t, std::string, int> key() const { return {person, exercise, n}; }
  };
  /// The newest exam, as the course's file has it; number 0: there was none.
  struct Newest {
    std::int64_t number = 0;
    Exam exam;
    std::int64_t opened_s = 0, ends_s = 0, closed_s = 0, alive_s = 0, down_s = 0;
    std::set<std::int64_t> people;
    std::vector<Trial> trials;
    bool is_open() const { return number != 0 && closed_s == 0; }
  };

  void ReadTrials();
  void Set(const char* column, std::int64_t value);
  void Open(const std::string& name, std::int64_t now_s);
  void Again(std::int64_t person);
  void Close(std::int64_t now_s);
  std::set<std::int64_t> PeopleOf(const Exam& exam) const;
  /// From 0; as many as there are tasks: all is done.
  std::size_t TaskOf(std::int64_t person) const;
  int DoneOf(std::int64_t person, std::size_t task) const;
  std::string NameOf(std::int64_t person) const;
  std::string RecordingOf(const Trial& trial) const;
  Seal SealOf(const Trial& trial, std::int64_t now_s) const;
  void SealNext(std::int64_t now_s);
  void TakeSeal();
  /// To be scored.
  bool Waits(const Trial& trial) const;
  void ScoreAll();
  void WriteRoll();
  /// Why a trial ended that its person did not end, and no time; empty: it ended in order.
  static std::string CutOf(const Trial& trial);
  /// What of the newest exam is for who teaches, and for who sits it.
  std::string ClassJson() const;
  std::string OwnJson(std::int64_t person) const;

  const std::string folder_;
  CourseFile& file_;
  Roster& roster_;
  TrialRoom& trials_;
  const SealKey key_;
  Newest newest_;
  std::vector<std::pair<Exam, std::string>> exams_;  // of files, or why one is none
  std::future<std::string> sealing_;
  std::tuple<std::int64_t, std::string, int> sealed_;           // by that
  std::set<std::tuple<std::int64_t, std::string, int>> tried_;  // to score
  std::string trouble_;                                         // for a teacher
  std::int64_t retry_s_ = 0;
  bool time_was_over_ = false;
  bool has_roll_ = false;
  bool changed_ = false;
};

}  // namespace palpate
