#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/course/course_file.h"

namespace SQLite {
class Statement;
}

namespace palpate {

/// The key of a trial in its table and on the roll of an exam.
struct TrialKey {
  std::int64_t person = 0;
  std::string exercise;
  int n = 0;  ///< the person's number of it in that exercise, from 1
  auto operator<=>(const TrialKey&) const = default;
};

/// A trial as stored in the table `trials`.
struct TrialRow {
  std::int64_t person = 0;
  std::string exercise;
  int n = 0;
  std::int64_t begun_s = 0, ended_s = 0;  ///< since 1970; no end: 0
  std::string reason;                     ///< why it ended
  bool whole = false;                     ///< complete so far
  std::optional<double> points;           ///< 0 to 100
  bool passed = false;
  std::string marks;  ///< JSON, as palpate-replay score wrote it
  std::optional<std::int64_t> submitted_s;
  bool scored = false;  ///< also without points, where nothing was touched

  TrialKey key() const { return {person, exercise, n}; }
  /// Returns whether it counts for grade, spread and losses: it is complete and has points.
  bool counts() const { return whole && points.has_value(); }
};

/// What a trial is worth, as in its row.
struct TrialScore {
  std::optional<double> points;
  bool passed = false;
  std::string marks;
};

/// The table `trials`: one row for each trial of each person.
/// Thread contract: as CourseFile.  Every function throws Error as CourseFile::Use does.
class TrialTable {
 public:
  /// Creates the table if it is missing.
  explicit TrialTable(CourseFile& file);

  /// Enters a trial that begins now.  Returns its number.
  int Begin(std::int64_t person, const std::string& exercise);
  /// Stores how a trial has ended.  @param submits  it is submitted by that.
  void End(const TrialKey& key, const std::string& reason, bool whole, bool submits);
  /// Ends, not whole, the trials that a killed gateway left running, and returns them.
  std::vector<TrialRow> EndLeftOver();
  /// Returns false if there is no ended trial of that key that is not submitted.
  bool Submit(const TrialKey& key);
  /// Stores what the scoring of a trial has found.   @param score  nothing: it failed
  void Score(const TrialKey& key, const std::string& reason, bool whole,
             const std::optional<TrialScore>& score);
  /// Stores a trial's seal.  @param ended  why it ended, not whole; empty: as stored.
  void Seal(const TrialKey& key, const std::string& seal, const std::string& ended);

  /// Returns the ended trials, sorted by person, exercise and number.  @param person  0: everybody.
  std::vector<TrialRow> Ended(std::int64_t person = 0) const;
  /// Returns the ended trials without a score that belong to no exam, in the order of their ends.
  /// @pre The exams' tables exist.
  std::vector<TrialRow> Unscored() const;

 private:
  CourseFile& file_;
};

/// What a query has to select first for TrialRowOf, the only reader of such a row.
extern const std::string kTrialColumns;
constexpr int kTrialColumnCount = 11;
TrialRow TrialRowOf(SQLite::Statement& row);

}  // namespace palpate
