#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <string>

#include "client/course/exercise.h"
#include "client/course/trial_table.h"
#include "common/program/child_program.h"

namespace palpate {

using TrialHolder = std::uint64_t;  ///< a viewer

/// A trial's state after a change.
struct TrialNews {
  TrialHolder holder = 0;  ///< 0: no viewer waits for it any more
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

  TrialKey key() const { return {person, exercise, n}; }
};

/// Returns the state of a trial that is stored.
TrialNews NewsOf(const TrialRow& row);

/// A trial that is being recorded or scored.
struct RunningTrial {
  TrialNews news;
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

/// Those trials, and what may be asked of them.
/// Thread contract: one thread.
class RunningTrials {
 public:
  /// Returns whether that viewer's trial runs: its tool may be moved.
  bool is_running(TrialHolder holder) const;
  bool is_at_one(TrialHolder holder) const;
  /// Returns the viewer of the person's running trial; 0: none runs.
  TrialHolder HolderOf(std::int64_t person) const;
  /// Returns whether a trial is being recorded in that scene or seat.
  bool is_in(const std::string& scene) const;
  /// Returns whether what is cut in that scene or seat is graded: a trial is being recorded there.
  bool is_cut_in(const std::string& scene) const;
  /// Returns whether a trial of that person is being recorded or scored.
  bool has_one_of(std::int64_t person) const;
  /// Returns whether that trial is being recorded or scored.
  bool Has(const TrialKey& key) const;
  /// Throws Error, worded for the person, while their last trial is being recorded or scored.
  void CheckMayBegin(std::int64_t person) const;
  std::size_t size() const { return all.size(); }

  std::list<RunningTrial> all;
};

}  // namespace palpate
