#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/course/course_file.h"
#include "client/course/exercise.h"
#include "client/course/roster.h"

namespace palpate {

/// A trial that has ended, as the table `trials` has it.
struct TrialRow {
  std::int64_t person = 0;
  std::string exercise;
  int n = 0;
  std::int64_t begun_s = 0, ended_s = 0;  ///< since 1970
  std::string reason;                     ///< why it ended
  bool whole = false;
  std::optional<double> points;  ///< 0 to 100
  bool passed = false;
  std::string marks;  ///< JSON, as palpate-replay score wrote it
  std::optional<std::int64_t> submitted_s;

  /// Only what is whole and has points counts for grade, spread and losses.
  bool counts() const { return whole && points.has_value(); }
};
/// Of one person, of one or more exercises, or of all: in the order of the table's key.
using TrialRows = std::span<const TrialRow>;

/// By person, exercise and number.  @param person  0: of everybody.  Throws Error.
std::vector<TrialRow> ReadTrials(CourseFile& file, std::int64_t person = 0);
/// Rows of one person and exercise stand together; calls it with each such group.
template <class Action>
void ForEachSeries(TrialRows rows, const Action& action) {
  for (std::size_t begin = 0, end = 0; begin < rows.size(); begin = end) {
    const auto is_other = [&](const TrialRow& row) {
      return row.person != rows[begin].person || row.exercise != rows[begin].exercise;
    };
    while (end < rows.size() && !is_other(rows[end])) ++end;
    action(rows.subspan(begin, end - begin));
  }
}

/// Points by criterion, in their order; empty where the row has none that can be read.
std::vector<std::pair<std::string, double>> MarksOf(const TrialRow& row);

/// The mean of the last trials that count, and how far it can be trusted.
struct TermGrade {
  int of = 0;  ///< trials; 0: there is no grade
  double mean = 0.0;
  /// Standard error of the mean: s / sqrt(of).  Of one trial there is none.
  std::optional<double> error;
  /// 95 % t-interval about the mean (Student, Biometrika 6 (1908) 1), within 0 to 100.  None of
  /// fewer than kLeastForInterval.
  std::optional<double> low, high;

  /// Of two trials the interval's half is 9 of their standard deviations: it says nothing.
  static constexpr int kLeastForInterval = 3;
};
/// @param rows  one person's of one exercise.   @param last  how many of them make a grade.
TermGrade GradeOf(TrialRows rows, int last);
/// Two-sided 95 %: 97.5th percentile of Student's t.  @param freedom  at least 1
double StudentT95(int freedom);

/// How a class did in its n-th trial of an exercise: quartiles by linear interpolation between
/// order statistics (definition 7 of Hyndman & Fan, Am. Stat. 50 (1996) 361).
struct TrialSpread {
  int n = 0;
  int people = 0;
  double low = 0.0, median = 0.0, high = 0.0;
};
/// @param values  at least one.   @param share  0 to 1
double QuantileOf(std::vector<double> values, double share);
/// What people got, by the trial's number.
using PointsByTrial = std::map<int, std::vector<double>>;
std::vector<TrialSpread> SpreadOf(const PointsByTrial& points);

/// What a criterion costs on the average, of 100 points of a trial.
struct CriterionLoss {
  std::string criterion;
  double points = 0.0;
  int of = 0;  ///< trials, or people
};
/// Over the last trials that count, most first.  A criterion's share of the points is its weight
/// over that of all; what the exercise does not ask for any more is left out, and a trial from
/// before a criterion was asked for does not count for it.
/// @param rows      one person's of one exercise.
/// @param exercise  null: it is gone, and all criteria weigh the same.
std::vector<CriterionLoss> LossesOf(TrialRows rows, const Exercise* exercise, int last);
/// Of a class: the mean over those who have been marked by it, each counting once.
std::vector<CriterionLoss> ClassLossesOf(const std::vector<std::vector<CriterionLoss>>& losses);

/// As programs read it; or with semicolons and decimal commas, which spreadsheets expect where
/// numbers are written with these.
enum class CsvAs { kRfc4180, kDecimalComma };

/// A course's trials and who did them; what pages and files tell of it.  Pure.
class History {
 public:
  /// A trial's score page as its address on the page; empty: it has none.
  using PageOf = std::function<std::string(const TrialRow& row)>;

  /// @param rows  as ReadTrials gives them; of everybody, for the class's spread.
  History(std::vector<Exercise> exercises, std::vector<Person> people, std::vector<TrialRow> rows);

  /// For a teacher: of each exercise the spread and what costs most, of each person the points,
  /// the grade, and what to practise next.
  std::string ClassJson() const;
  /// Of a person: all trials with marks, grades, what to practise next, and the class's spread, for
  /// the person only where it is of at least kLeastForOthers: fewer would tell who had what.
  std::string PersonJson(std::int64_t person, bool for_teacher, const PageOf& page) const;
  /// A line each trial (README.md has the columns).  @param person  0: of everybody.
  std::string Csv(std::int64_t person = 0, CsvAs as = CsvAs::kRfc4180) const;

  static constexpr int kLeastForOthers = 5;

 private:
  const Exercise* Find(const std::string& exercise) const;
  /// How many trials make a grade.
  int LastOf(const std::string& exercise) const;
  const Person* PersonOf(std::int64_t person) const;
  TrialRows RowsOf(std::int64_t person) const;
  /// By exercise, of those who are taught.
  std::map<std::string, PointsByTrial> ClassPoints() const;

  std::vector<Exercise> exercises_;
  std::vector<Person> people_;
  std::vector<TrialRow> rows_;
};

/// A CSV field: quoted where RFC 4180, or a list apart by semicolons, asks for it; with ' before a
/// text that a spreadsheet would run (one that begins with = + - @, a tab or a carriage return).
std::string CsvField(const std::string& text);

}  // namespace palpate
