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
#include "client/course/course_lock.h"
#include "client/course/exercise.h"
#include "common/program/child_program.h"

namespace palpate {

/// The trials of a course's people.  Each has its own palpate-record that records it, a
/// palpate-replay that scores it by following the recording, and a row in the course's file.  Trial
/// N is recorded in FOLDER/trials/PERSON/EXERCISE/N.mcap; its score page is N/score.html there.
/// Thread contract: one thread.  Times are in nanoseconds.
class TrialRoom {
 public:
  using Holder = std::uint64_t;  ///< a viewer
  struct Options {
    std::string folder;    ///< of the course
    std::string programs;  ///< folder with palpate-record and palpate-replay
    /// Command-line arguments by which the recorder reaches the stations' network.
    std::vector<std::string> network;
  };
  /// A trial's state after a change.
  struct News {
    Holder holder = 0;  ///< 0: no viewer waits for it any more
    std::int64_t person = 0;
    std::string exercise;
    int n = 0;
    /// "preparing", "running", "ending", "unentered" while its end cannot be stored, "waiting" for
    /// its turn to be scored, "scoring", "scored", or "unscored" if scoring failed.  In an exam
    /// "kept" takes the place of the last four.
    std::string phase;
    int ahead = 0;       ///< while it waits: the number of trials whose scores come first
    std::string reason;  ///< why it ended, and what went wrong
    bool whole = true;   ///< its recording is complete
    std::optional<double> points;
    bool passed = false;
    bool submitted = false;
    std::string page;  ///< key of the score page, below /score/; empty: there is none
    double left_s = 0.0;
  };

  /// Creates the table, and marks trials that a killed gateway left running as cut
  /// short.  Throws Error, also if another process keeps the trials of this folder.
  TrialRoom(Options options, CourseFile& file, std::function<void(const News&)> tell);

  const std::string& folder() const { return options_.folder; }  ///< of the course
  const CourseLock& lock() const { return lock_; }
  const std::vector<Exercise>& exercises() const { return exercises_; }
  const Exercise* Find(const std::string& exercise) const;

  /// Starts a trial's recorder; the news "running" says that the tool may now be taken.  Throws
  /// Error, worded for the person, if it cannot begin.
  /// @param station  the station that the person's hand will use.
  /// @param scene    that scene or seat; the trial runs once the recorder has it.
  /// @param exam_s   time limit in an exam, in place of the exercise's; the trial is
  /// then not scored.
  /// Returns the trial's number.
  int Begin(Holder holder, std::int64_t person, const std::string& exercise,
            const std::string& station, const std::string& scene, std::int64_t now_ns,
            std::optional<double> exam_s = {});
  /// Ends the trial of that viewer, if it has one.   @param whole  false: it is cut short
  void End(Holder holder, const std::string& reason, bool whole = true);
  /// Returns whether that viewer's trial runs: its tool may be moved.
  bool is_running(Holder holder) const;
  /// Returns the viewer of the person's running trial; 0: none runs.
  Holder HolderOf(std::int64_t person) const;
  /// Another viewer of the person goes on with the running trial of `holder`.
  void Return(Holder holder, Holder to, std::int64_t now_ns);
  /// Ends the running trials of these people.
  void EndOf(const std::set<std::int64_t>& people, const std::string& reason);
  /// Ends the running trials in a scene that was changed under them; they are not whole.
  void EndIn(const std::string& scene, const std::string& reason);
  /// Scores an ended trial: of a closed exam, or of an earlier run of the gateway.
  /// @param kept      the trial's last news.
  /// @param length_s  how long it ran; bounds the time that its scoring may take.
  void Score(const News& kept, double length_s);
  /// Scores ended trials that have no score and belong to no exam.  @pre The exam's tables exist.
  void ScoreLeftovers();
  /// Submits a trial; a running one ends.  Throws Error if there is no such trial.
  void Submit(Holder holder, std::int64_t person, const std::string& exercise, int n);
  bool is_at_one(Holder holder) const;
  /// Returns whether a trial is being recorded in that scene or seat.
  bool is_in(const std::string& scene) const;
  /// Returns whether what is cut in that scene or seat is graded: a trial is being recorded there.
  bool is_cut_in(const std::string& scene) const;
  /// Returns whether a trial of that person is being recorded or scored.
  bool has_one_of(std::int64_t person) const;
  /// Returns whether that trial is being recorded or scored.
  bool Has(std::int64_t person, const std::string& exercise, int n) const;
  /// Throws Error, worded for the person, while their last trial is being recorded or scored.
  void CheckMayBegin(std::int64_t person) const;
  /// Advances all trials; to be called some 100 times a second.
  void Poll(std::int64_t now_ns);
  /// The number of trials that are being recorded or scored.
  std::size_t size() const { return trials_.size(); }

  /// Returns the exercises, each with the person's trials so far, for the person's page.
  /// @param teaches  each also with the scene that palpate-server is to be told.
  std::string ListJson(std::int64_t person, bool teaches = false);
  /// Returns the keys of a person's existing score pages, by exercise and trial number.
  std::map<std::pair<std::string, int>, std::string> PagesOf(std::int64_t person);
  /// Returns "trial 3 of 'caries' by Anna", for a log.
  std::string NameOf(const News& news);
  /// Describes one exercise, without hints.  @param exercise  must exist.
  std::string DescribeJson(const std::string& exercise) const;
  /// Invalidates the keys of these people's score pages.  A later request creates new keys.
  void ForgetPages(const std::set<std::int64_t>& people);
  /// Returns the path of the score page with that key (News::page); empty: there is none.
  std::string PageOf(const std::string& key) const;
  /// Returns the path of an exercise's picture, given as "EXERCISE/FILE"; empty: there is none.
  std::string PictureOf(const std::string& path) const;

 private:
  struct Running {
    News news;
    const Exercise* exercise = nullptr;
    std::string scene;
    std::unique_ptr<ChildProgram> recorder, scorer;
    bool records = false;
    bool follows = false;     // the scorer has begun to follow, so it may be interrupted
    bool cuts_short = false;  // the recording has no end, so the scorer must be interrupted
    bool submits = false;
    bool is_exam = false;
    double most_s = 0.0;
    std::string trouble;        // why its end could not be stored
    std::int64_t retry_ns = 0;  // when to retry storing its end; 0: not tried yet
    std::int64_t asked_ns = 0;  // when it was asked to begin, to end, or to be scored
    std::uint64_t place = 0;    // in the queue for scoring: who ended first comes first
    bool is_overdue = false;    // its scoring took too long and was ended
    std::int64_t began_ns = 0;
  };
  void MarkCutShort();
  std::string FolderOf(std::int64_t person, const std::string& exercise) const;
  /// Returns a person's name; empty: it cannot be read.
  std::string NameOf(std::int64_t person);
  /// Returns false once the trial is finished.
  bool PollOne(Running& trial, std::int64_t now_ns);
  void BeginToEnd(Running& trial, const std::string& reason);
  /// Stores in the course's file how the trial ended.  Returns false if that cannot be written now.
  bool Keep(Running& trial, std::int64_t now_ns);
  void BeginScoring(Running& trial, bool follows);
  void Score(Running& trial);
  /// Starts the scoring of the next trials in turn, and tells the others how many are ahead.
  void ScoreNext();
  /// Returns the time that the scoring of the trial may take.
  static double MostToScore_s(const Running& trial);
  void TakeScore(Running& trial);
  void Tell(Running& trial, const std::string& phase);
  std::string KeyOf(const std::string& page);

  Options options_;
  const CourseLock lock_;
  CourseFile& file_;
  std::function<void(const News&)> tell_;
  std::vector<Exercise> exercises_;
  std::list<Running> trials_;
  std::uint64_t places_ = 0;
  std::map<std::string, std::string> pages_;  // files, by key
};

}  // namespace palpate
