#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/replayer/hand_path.h"
#include "client/replayer/score/cut_measures.h"
#include "client/replayer/score/score.h"

namespace palpate {

/// One thing that a trial is graded by: `best` earns everything, `worst` nothing, and what lies
/// between its share.
struct Criterion {
  std::string name, why;
  std::string measure;        ///< one of kMeasures
  double limit_N = 0.0;       ///< of "force_over_share"
  std::string tissue{};       ///< of some measures of what was cut
  Vec3 axis = Vec3::UnitY();  ///< unit, W: of a preparation, out of the solid
  Place place{};              ///< what lies elsewhere does not count
  double best = 0.0, worst = 1.0;
  double weight = 1.0;
};

/// A place whose depth is to be probed.
struct ProbingSite {
  std::string name;
  Vec3 margin = Vec3::Zero();  ///< W [m]: where depth is counted from
  Vec3 into = -Vec3::UnitY();  ///< unit, W: along which it is
  double radius = 0.0;         ///< [m]: how far from that line the tip may be
  double depth = 0.0;          ///< [m]: what is right
  double tolerance = 0.0;      ///< [m]
};

/// By what a teacher grades: a file that a teacher edits.
struct Criteria {
  std::string file, title;
  double pass = 0.0;        ///< of 100
  Vec3 tip = Vec3::Zero();  ///< of the tool, in its frame [m]
  std::vector<Criterion> criteria{};
  std::vector<ProbingSite> sites{};
};

struct Measure {
  const char* name;
  const char* unit;
  const char* text;
  double Score::*of_score = nullptr;  ///< none: it is computed of the trial
  enum class Tissue { kNone, kMayName, kMustName };
  Tissue tissue = Tissue::kNone;
  bool of_cut = false;       ///< of what was cut
  bool along_axis = false;   ///< of a preparation
  bool in_a_place = of_cut;  ///< a place may be named
};
/// What a criterion may be about.
extern const std::vector<Measure> kMeasures;
const Measure& MeasureOf(const std::string& name);

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

/// Throws Error "file:line: field: what is wrong; remedy".
Criteria LoadCriteria(const std::string& file);
/// For a teacher to begin with: periodontal probing with 25 g.
extern const char* const kCriteriaToBeginWith;

/// A measure of what was cut; none where there was nothing to measure.
using MeasureOfCut = std::function<std::optional<double>(const Criterion& criterion)>;

/// Nothing where the trial touches nothing: least force is then no merit.
/// @param trainee  the trial (TrialIn) that the score is of.
/// @param of_cut   needed where AsksForCuts.
std::optional<Grade> GradeTrial(const Criteria& criteria, const Score& score,
                                const HandPath& trainee, const MeasureOfCut& of_cut = nullptr);
/// Whether a criterion is about what was cut.
bool AsksForCuts(const Criteria& criteria);

/// A criterion's measure of what a trial's burs left, beside what the expert's left.
/// @param shape  of the trial.   @param file  of the criteria, for what is thrown.
/// Throws Error where a criterion is about a tissue that the scene does not have.
std::optional<double> MeasureCut(const Criterion& criterion, const SolidsCut& expert,
                                 const SolidsCut& trial, const CutShape& shape,
                                 const std::string& file);

}  // namespace palpate
