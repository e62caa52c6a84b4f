#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "client/course/exercise.h"
#include "client/replayer/score/criteria.h"
#include "client/replayer/score/cut_picture.h"
#include "client/replayer/score/score.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// How several trials of a trainee did beside an expert.
struct Report {
  std::string expert;  ///< the recording's name
  std::vector<Trial> trials;
  /// What burs left of each tissue, the expert's and as trials; empty where nothing can be cut.
  std::vector<TissueCut> expert_cut;
  std::vector<std::vector<TissueCut>> cuts;
  /// Of the trials to what the expert left; as pictures, the expert's first.
  std::vector<TargetDifference> differences;
  std::vector<CutPicture> pictures;
  std::optional<Criteria> criteria;
  /// As trials, where there are criteria; none of a trial that touches nothing.
  std::vector<std::optional<Grade>> grades;
};

/// Of several numbers.
struct Average {
  double mean = 0.0;
  double deviation = 0.0;  ///< of a sample; 0 of one
};
Average AverageOf(const std::vector<double>& values);

/// What is to be set beside what.
struct ScoreOptions {
  std::string
      expert;  ///< recording; or a script, NAME.path.json, that is done in the trials' scene
  std::vector<std::string> trials;  ///< recordings of the trainee
  /// Whose session, as SessionChoice says; of the trials one for all, or one each.
  std::string expert_station;
  std::vector<std::string> stations;
  std::string criteria;  ///< file to grade by; empty: no grades
  bool follow = false;   ///< the only trial is being recorded
};

/// @param stop  null: the trials are there.  Else the only one is being recorded, and all that can
///              be is done before its end, or a signal.
/// Throws Error.
Report MakeReport(const ScoreOptions& options, StopSignal* stop = nullptr);
/// The expert of an exercise beside himself, as far as he comes in that time [s]: whether he passes
/// by its criteria, and who does not get far fails.  Throws Error.
Report Rehearse(const Exercise& exercise, double until_s = std::numeric_limits<double>::infinity());
/// The average of the trials that have a grade is enough.
bool Passed(const Report& report);
std::string ToText(const Report& report);
/// @param file  "-" is stdout.  Throws Error.
void WriteJson(const Report& report, const std::string& file);
/// One page that stands alone: verdict, marks, sites, paths in space, forces, figures.
std::string ToHtml(const Report& report);
/// score.html, score.svg and score.json into a folder, which is made.  Throws Error.
void WriteReport(const Report& report, const std::string& folder);
/// Those that come with a scene of the catalogue; where none is named, kCriteriaToBeginWith.
/// Throws Error, also where there is such a file.
void WriteNewCriteria(const std::string& file, const std::string& scene = "");

}  // namespace palpate
