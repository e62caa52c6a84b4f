#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "client/course/course_file.h"
#include "client/course/course_lock.h"
#include "client/course/exercise_pages.h"
#include "client/course/roster_table.h"
#include "client/course/running_trials.h"
#include "client/course/trial_table.h"

namespace palpate {

/// The trials of a course's people.  Each has its own palpate-record that records it, a
/// palpate-replay that scores it by following the recording, and a row in the course's file.  Trial
/// N is recorded in FOLDER/trials/PERSON/EXERCISE/N.mcap; its score page is N/score.html there.
/// Thread contract: one thread.  Times are in nanoseconds.
class TrialRoom {
 public:
  using Holder = TrialHolder;
  using News = TrialNews;
  struct Options {
    std::string folder;    ///< of the course
    std::string programs;  ///< folder with palpate-record and palpate-replay
    /// Command-line arguments by which the recorder reaches the stations' network.
    std::vector<std::string> network;
  };
  /// Creates the table, and marks trials that a killed gateway left running as cut
  /// short.  Throws Error, also if another process keeps the trials of this folder.
  TrialRoom(Options options, CourseFile& file, std::function<void(const News&)> tell);

  const CourseLock& lock() const { return lock_; }
  ExercisePages& pages() { return pages_; }
  const RunningTrials& now() const { return trials_; }

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
  /// Advances all trials; to be called some 100 times a second.
  void Poll(std::int64_t now_ns);

 private:
  using Running = RunningTrial;

  /// Returns "trial 3 of 'caries' by Anna", for a log.
  std::string NameOf(const News& news) const;
  /// Returns the path of the trial's recording, without its ending.
  std::string StemOf(const News& news) const;
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

  Options options_;
  const CourseLock lock_;
  TrialTable table_;
  RosterTable people_;
  ExercisePages pages_;
  std::function<void(const News&)> tell_;
  RunningTrials trials_;
  std::uint64_t places_ = 0;
};

}  // namespace palpate
