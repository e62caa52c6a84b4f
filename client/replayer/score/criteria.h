#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/course/criteria_file.h"
#include "client/replayer/hand_path.h"
#include "client/replayer/score/cut_measures.h"
#include "client/replayer/score/score.h"

namespace palpate {

/// The deepest that the tool's tip has been in a site; none where it never was in it [m].
std::optional<double> DepthIn(const ProbingSite& site, const Vec3& tip, const HandPath& path);

/// How a trial did.
struct Grade {
  struct Mark {
    std::optional<double> value;  ///< in the measure's unit; none: there was nothing to measure
    double points = 0.0;          ///< 0 to 100
  };
  std::vector<Mark> marks;                    ///< as Criteria::criteria
  std::vector<std::optional<double>> depths;  ///< as Criteria::sites [m]
  double points = 0.0;                        ///< 0 to 100: the marks' mean by weight
};

/// A measure of what was cut; none where there was nothing to measure.
using MeasureOfCut = std::function<std::optional<double>(const Criterion& criterion)>;

/// Nothing where the trial touches nothing: least force is then no merit.
/// @param trainee  the trial (TrialIn) that the score is of.
/// @param of_cut   needed where AsksForCuts.
std::optional<Grade> GradeTrial(const Criteria& criteria, const Score& score,
                                const HandPath& trainee, const MeasureOfCut& of_cut = nullptr);
/// A criterion's measure of what a trial's burs left, beside what the expert's left.
/// @param shape  of the trial.   @param file  of the criteria, for what is thrown.
/// Throws Error where a criterion is about a tissue that the scene does not have.
std::optional<double> MeasureCut(const Criterion& criterion, const SolidsCut& expert,
                                 const SolidsCut& trial, const CutShape& shape,
                                 const std::string& file);

}  // namespace palpate
