#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/course/course_file.h"
#include "client/course/exercise.h"
#include "common/program/child_program.h"

namespace palpate {

/// The trials of a course's people: each is recorded by a palpate-record of its own, scored by a
/// palpate-replay that follows the recording, and has a row in the course's file.  In
/// FOLDER/trials/PERSON/EXERCISE/ trial N is N.mcap, and its score page N/score.html. Thread
/// contract: one thread.  Time is given [ns].
class TrialRoom {
 public:
  using Holder = std::uint64_t;  ///< a viewer
  struct Options {
    std::string folder;    ///< of the course
    std::string programs;  ///< folder of palpate-record and palpate-replay
    /// Of the recorder: where the stations are.
    std::vector<std::string> network;
  };
  /// What became of a trial.
  struct News {
    Holder holder = 0;  ///< 0: nobody is at it any more
    std::int64_t person = 0;
    std::string exercise;
    int n = 0;
    /// "preparing", "running", "ending", "scoring", "scored"; "unscored" where that failed.  Of an
    /// exam "kept" in place of the last three.
    std::string phase;
    std::string reason;  ///< why it ended, and what is wrong
    bool whole = true;   ///< nothing of it is missing
    std::optional<double> points;
    bool passed = false;
    bool submitted = false;
    std::string page;  ///< of the score, below /score/; empty: there is none
    double left_s = 0.0;
  };

  /// Makes its table, and marks as cut short what a killed gateway left.  Throws Error.
  TrialRoom(Options options, CourseFile& file, std::function<void(const News&)> tell);

  const std::vector<Exercise>& exercises() const { return exercises_; }
  const Exercise* Find(const std::string& exercise) const;

  /// Starts its recorder; "running" tells that the tool may now be taken.  Throws Error, for the
  /// person, where it cannot be.
  /// @param station  that the person's hand will have.
  /// @param exam_s   of an exam: its time, in place of the exercise's.  It is not scored then.
  /// Returns its number.
  int Begin(Holder holder, std::int64_t person, const std::string& exercise,
            const std::string& station, std::int64_t now_ns, std::optional<double> exam_s = {});
  /// Ends the trial that a viewer is at, if it is.
  void End(Holder holder, const std::string& reason);
  /// Ends what they are at.
  void EndOf(const std::set<std::int64_t>& people, const std::string& reason);
  /// Scores what has ended: of an exam that is closed, or of an earlier run of the gateway.
  /// @param kept  what was told of it.
  void Score(const News& kept);
  /// Scores what has no score yet and is of no exam.  @pre The exam's tables are there.
  void ScoreLeftovers();
  /// Hands a trial in; one that is running ends.  Throws Error where there is none.
  void Submit(Holder holder, std::int64_t person, const std::string& exercise, int n);
  bool is_at_one(Holder holder) const;
  /// One of that person's is recorded or scored.
  bool has_one_of(std::int64_t person) const;
  /// That trial is not done with.
  bool Has(std::int64_t person, const std::string& exercise, int n) const;
  /// Throws Error, for the person, while one that they have begun is not done with.
  void CheckMayBegin(std::int64_t person) const;
  /// Looks after them, some 100 times a second.
  void Poll(std::int64_t now_ns);
  /// Trials that are not done with.
  std::size_t size() const { return trials_.size(); }

  /// For a person's page: the exercises, and of each its trials so far.
  std::string ListJson(std::int64_t person);
  /// Keys of a person's score pages, by exercise and number, of those that there are.
  std::map<std::pair<std::string, int>, std::string> PagesOf(std::int64_t person);
  /// An exercise alone, without hints.  @param exercise  one that there is.
  std::string DescribeJson(const std::string& exercise) const;
  /// Ends the keys of their score pages.  Who asks for one later gets another.
  void ForgetPages(const std::set<std::int64_t>& people);
  /// The score page that a key of News stands for; empty: none.
  std::string PageOf(const std::string& key) const;
  /// An exercise's picture, "EXERCISE/FILE"; empty: none.
  std::string PictureOf(const std::string& path) const;

 private:
  struct Running {
    News news;
    const Exercise* exercise = nullptr;
    std::unique_ptr<ChildProgram> recorder, scorer;
    bool records = false;
    bool follows = false;     // the scorer has said so: it may be interrupted
    bool cuts_short = false;  // the recording has no end, of which it is to be told
    bool submits = false;
    bool is_exam = false;
    double most_s = 0.0;
    std::int64_t retry_ns = 0;  // to enter its end; 0: it has not been tried
    std::int64_t asked_ns = 0;  // to begin, or to end
    std::int64_t began_ns = 0;
  };
  void MarkCutShort();
  std::string FolderOf(std::int64_t person, const std::string& exercise) const;
  /// False once it is done with.
  bool PollOne(Running& trial, std::int64_t now_ns);
  void BeginToEnd(Running& trial, const std::string& reason);
  /// Enters in the course's file how it ended.  False where that cannot be written now.
  bool Keep(Running& trial, std::int64_t now_ns);
  void BeginScoring(Running& trial, bool follows);
  void Score(Running& trial);
  void ScoreNext();
  void TakeScore(Running& trial);
  void Tell(Running& trial, const std::string& phase);
  std::string KeyOf(const std::string& page);

  Options options_;
  CourseFile& file_;
  std::function<void(const News&)> tell_;
  std::vector<Exercise> exercises_;
  std::list<Running> trials_;
  std::map<std::string, std::string> pages_;  // files, by key
};

}  // namespace palpate
