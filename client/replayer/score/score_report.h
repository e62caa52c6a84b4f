#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/course/exercise.h"
#include "client/replayer/score/criteria.h"
#include "client/replayer/score/cut_picture.h"
#include "client/replayer/score/score.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// The results of several trials of a trainee, compared with an expert.
struct Report {
  std::string expert;         ///< name of the recording
  std::string person{};       ///< whose trials they are; empty: unknown
  std::int64_t begun_ns = 0;  ///< of the first trial, since 1970; 0: unknown
  std::vector<Trial> trials;
  std::vector<int> sessions;  ///< of each trial; several if its station lost its server (join)
  /// Tissues left by the expert, and by each trial; empty if nothing can be cut.
  std::vector<TissueCut> expert_cut;
  std::vector<std::vector<TissueCut>> cuts;
  /// Differences of the trials from the expert's result, and the pictures, the expert's first.
  std::vector<TargetDifference> differences;
  std::vector<CutPicture> pictures;
  std::optional<Criteria> criteria;
  /// One per trial if there are criteria; none for a trial that touches nothing.
  std::vector<std::optional<Grade>> grades;
};

/// Mean and deviation of several numbers.
struct Average {
  double mean = 0.0;
  double deviation = 0.0;  ///< of a sample; 0 for one number
};
Average AverageOf(const std::vector<double>& values);

/// What to compare with what.
struct ScoreOptions {
  std::string expert;  ///< recording, or a script (NAME.path.json) performed in the trials' scene
  std::vector<std::string> trials;  ///< recordings of the trainee
  /// Sessions, as in SessionChoice; for the trials, one for all or one each.
  std::string expert_station = {};
  std::vector<std::string> stations = {};
  std::string criteria = {};  ///< file to grade by; empty: no grades
  bool follow = false;        ///< the only trial is still being recorded
  bool join = false;          ///< the sessions of a trial's station are one trial
  std::string person = {};    ///< whose trials they are, for the page
};

/// @param stop  null: all trials are complete.  Otherwise the only one is being recorded; its
///              report is prepared meanwhile, up to its end or a signal.
/// Throws Error.
Report MakeReport(const ScoreOptions& options, StopSignal* stop = nullptr);
/// Other hands that an exercise is rehearsed with; they may depend on the expert's trial.
using OtherHands = std::function<std::vector<PoseScript>(const HandPath& expert)>;
/// Compares the expert of an exercise with himself: checks that he passes by its criteria.
/// @param others  compared with him too, each as a further trial.  Throws Error.
Report Rehearse(const Exercise& exercise, const OtherHands& others = nullptr);
/// Returns whether the average grade of the trials is enough.
bool Passed(const Report& report);
std::string ToText(const Report& report);
/// @param file  "-" is stdout.  Throws Error.
void WriteJson(const Report& report, const std::string& file);
/// Returns one self-contained page: verdict, marks, sites, paths in space, forces, figures.
std::string ToHtml(const Report& report);
/// Writes score.html, score.svg and score.json into a folder, which it creates.  Throws Error.
void WriteReport(const Report& report, const std::string& folder);
/// Writes the criteria of a scene of the catalogue; kCriteriaToBeginWith if none is named.  Throws
/// Error, also if the file exists.
void WriteNewCriteria(const std::string& file, const std::string& scene = "");

}  // namespace palpate
