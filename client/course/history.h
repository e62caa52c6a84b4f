#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/course/exercise.h"
#include "client/course/roster_table.h"
#include "client/course/trial_table.h"

namespace palpate {

/// Rows in the order of the table's key: of one person or of all, of one or more exercises.
using TrialRows = std::span<const TrialRow>;

/// Calls `action` with each group of adjacent rows that have the same person and exercise.
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

struct TrialMark {
  std::string criterion;
  double points = 0.0;
  double ungated = 0.0;  ///< before the task's gates took what they take; at least the points
};
/// Returns the marks in the stored order; empty if the row has none that can be read.
std::vector<TrialMark> MarksOf(const TrialRow& row);

/// The mean points of the last trials that count, and its uncertainty.
struct TermGrade {
  int of = 0;  ///< number of trials; 0: there is no grade
  double mean = 0.0;
  /// Standard error of the mean, s / sqrt(of); none for a single trial.
  std::optional<double> error;
  /// 95 % t-interval about the mean (Student, Biometrika 6 (1908) 1), clamped to 0 to 100.  None
  /// for fewer than kLeastForInterval trials.
  std::optional<double> low, high;

  /// For two trials the interval's half-width is 9 of their standard deviations,
  /// which tells nothing.
  static constexpr int kLeastForInterval = 3;
};
/// @param rows  one person's trials of one exercise.   @param last  how many trials make a grade.
TermGrade GradeOf(TrialRows rows, int last);
/// Returns the 97.5th percentile of Student's t (two-sided 95 %).  @param freedom  degrees of
/// freedom, at least 1.
double StudentT95(int freedom);

/// The points of a class in the n-th trial of an exercise: quartiles by linear interpolation
/// between order statistics (definition 7 of Hyndman & Fan, Am. Stat. 50 (1996) 361).
struct TrialSpread {
  int n = 0;
  int people = 0;
  double low = 0.0, median = 0.0, high = 0.0;
};
/// @param values  at least one.   @param share  0 to 1
double QuantileOf(std::vector<double> values, double share);
/// The points of all people, by trial number.
using PointsByTrial = std::map<int, std::vector<double>>;
std::vector<TrialSpread> SpreadOf(const PointsByTrial& points);

/// The points, of a trial's 100, that a criterion costs on average.
struct CriterionLoss {
  std::string criterion;
  double points = 0.0;
  int of = 0;  ///< number of trials or of people
};
/// Returns the mean loss per criterion over the last trials that count, largest first.  A
/// criterion's share of the points is its weight over the sum of all weights; what gates take from
/// others, they cost.  Criteria that the exercise no longer has are left out, and a trial older
/// than a criterion does not count for it.
/// @param rows      one person's trials of one exercise.
/// @param exercise  null: it no longer exists, and all criteria weigh the same.
std::vector<CriterionLoss> LossesOf(TrialRows rows, const Exercise* exercise, int last);
/// Returns the class's losses: for each criterion the mean over the people marked by it,
/// each counted once.
std::vector<CriterionLoss> ClassLossesOf(const std::vector<std::vector<CriterionLoss>>& losses);

/// How a CSV is written: for programs; with semicolons and decimal commas, or decimal points (as in
/// Switzerland), for spreadsheets of countries that write numbers so.
enum class CsvAs { kRfc4180, kDecimalComma, kSemicolon };

/// The trials of a course with the people who did them, and the reports made from them.  Pure.
class History {
 public:
  /// Returns the address of a trial's score page on the web page; empty: it has none.
  using PageOf = std::function<std::string(const TrialRow& row)>;

  /// @param rows  as TrialTable::Ended returns them, of everybody: the class's spread needs all.
  History(std::vector<Exercise> exercises, std::vector<Person> people, std::vector<TrialRow> rows);

  /// Returns the teacher's report: for each exercise the spread and the costliest criteria; for
  /// each person the points, the grade and what to practise next.
  std::string ClassJson() const;
  /// Returns a person's report: all trials with marks, grades, what to practise next, and the
  /// class's spread.  The person gets a spread only if it covers at least kLeastForOthers people,
  /// since a smaller one would reveal individual results.
  std::string PersonJson(std::int64_t person, bool for_teacher, const PageOf& page) const;
  /// Returns a CSV with one line per trial (README.md lists the columns).  @param
  /// person  0: everybody.
  std::string Csv(std::int64_t person = 0, CsvAs as = CsvAs::kRfc4180) const;

  static constexpr int kLeastForOthers = 5;

 private:
  const Exercise* Find(const std::string& exercise) const;
  /// Returns how many trials make a grade.
  int LastOf(const std::string& exercise) const;
  const Person* PersonOf(std::int64_t person) const;
  TrialRows RowsOf(std::int64_t person) const;
  /// Returns the points of people who are taught, by exercise.
  std::map<std::string, PointsByTrial> ClassPoints() const;

  std::vector<Exercise> exercises_;
  std::vector<Person> people_;
  std::vector<TrialRow> rows_;
};

/// Returns a CSV field: quoted if RFC 4180 or the semicolon-separated form requires it, and
/// with ' before a text that a spreadsheet would run as a formula (it begins with = + - @, a
/// tab or a carriage return).
std::string CsvField(const std::string& text);

}  // namespace palpate
