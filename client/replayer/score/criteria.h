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

/// Returns the greatest depth in a site at which the tool touched [m], by its tip; none if it never
/// did.
std::optional<double> DepthIn(const ProbingSite& site, const Vec3& tip, const HandPath& path);

/// The grade of a trial.
struct Grade {
  struct Mark {
    std::optional<double> value;  ///< in the measure's unit; none: nothing to measure
    double ungated = 0.0;         ///< points that the value alone would earn, 0 to 100
    double points = 0.0;          ///< 0 to 100; ungated * done * harmless, see Criterion
  };
  std::vector<Mark> marks;                    ///< in the order of Criteria::criteria
  std::vector<std::optional<double>> depths;  ///< in the order of Criteria::sites [m]
  double done = 1.0;  ///< how far the task is: product of the gates' shares; 1: there is no gate
  double harmless = 1.0;  ///< likewise how far no harm was done
  double points = 0.0;    ///< 0 to 100: weighted mean of the marks
};

/// Returns a measure of what was cut; none if there was nothing to measure.
using MeasureOfCut = std::function<std::optional<double>(const Criterion& criterion)>;

/// Grades a trial.  Returns nothing if it touches nothing: a small force is no merit then.
/// @param trainee  the trial (TrialIn) that the score is of.
/// @param of_cut   needed if AsksForCuts.
std::optional<Grade> GradeTrial(const Criteria& criteria, const Score& score,
                                const HandPath& trainee, const MeasureOfCut& of_cut = nullptr);
/// Returns a criterion's measure of what the trial's burs left, compared with the expert's result.
/// @param shape  of the trial.   @param file  of the criteria, for error messages.
/// Throws Error if a criterion names a tissue that the scene does not have.
std::optional<double> MeasureCut(const Criterion& criterion, const SolidsCut& expert,
                                 const SolidsCut& trial, const CutShape& shape,
                                 const std::string& file);

}  // namespace palpate
