#include "client/replayer/score/criteria.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/error.h"
#include "common/text/joined.h"

namespace palpate {
namespace {

/// A tip that touches rests as long as it stays so near to where its rest began [m]: it feels the
/// same spot, and a hand trembles less (0.1 to 0.3 mm).
constexpr double kRest_m = 5e-4;

/// The time that the tool's tip spent in the criterion's place.
struct TimeThere {
  double all_s = 0.0, contact_s = 0.0;
  double over_s = 0.0;  ///< with more force than the limit
  double rest_s = 0.0;  ///< the longest rest
};
TimeThere TimeIn(const Criterion& criterion, const Vec3& tip, const HandPath& path) {
  TimeThere time;
  Vec3 rest = Vec3::Zero();  // where it began
  double rests_s = -1.0;     // for how long; -1: it does not rest
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Vec3 at = path.tool()[i] * tip;
    const bool is_there = !criterion.place || criterion.place->Holds(at);
    if (!is_there || !path.touches(i)) {
      rests_s = -1.0;
    } else if (rests_s < 0.0 || (at - rest).norm() > kRest_m) {
      rest = at;
      rests_s = 0.0;
    }
    if (!is_there) continue;
    const double step_s = path.time_s[i] - path.time_s[i - 1];
    time.all_s += step_s;
    if (path.touches(i)) time.contact_s += step_s;
    if (rests_s >= 0.0) time.rest_s = std::max(time.rest_s, rests_s += step_s);
    if (path.force_N[i].norm() > criterion.limit_N) time.over_s += step_s;
  }
  return time;
}

double ShareRight(const Criteria& criteria, const std::vector<std::optional<double>>& depths) {
  std::size_t right = 0;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const ProbingSite& site = criteria.sites[i];
    right += depths[i] && std::abs(*depths[i] - site.depth) <= site.tolerance;
  }
  return static_cast<double>(right) / static_cast<double>(std::max<std::size_t>(1, depths.size()));
}

double OfTissue(const Criterion& criterion, const SolidsCut& trial, const CutShape& shape,
                const std::string& file) {
  const std::vector<TissueCut> cut =
      criterion.place ? TissuesOf(trial, criterion.place) : shape.tissues();
  const auto tissue = std::ranges::find(cut, criterion.tissue, &TissueCut::name);
  if (tissue == cut.end()) {
    throw Error(
        file + ": criterion '" + criterion.name + "': no tissue that can be cut is named '" +
        criterion.tissue + "'; " +
        (cut.empty() ? "the scene has no solid" : "there is: " + Joined(cut, &TissueCut::name)));
  }
  if (criterion.measure == "removed_mm3") return tissue->removed_mm3();
  return tissue->before_mm3 > 0.0 ? tissue->after_mm3 / tissue->before_mm3 : 0.0;
}

std::optional<double> ValueOf(const Criterion& criterion, const Criteria& criteria,
                              const Score& score, const HandPath& trainee,
                              const MeasureOfCut& of_cut, const Grade& grade) {
  if (MeasureOf(criterion.measure).of_cut) return of_cut(criterion);
  const TimeThere time = TimeIn(criterion, criteria.tip, trainee);
  if (criterion.measure == "force_over_share") {
    return time.contact_s > 0.0 ? time.over_s / time.contact_s : 0.0;
  }
  if (criterion.measure == "time_s") return time.all_s;
  if (criterion.measure == "contact_s") return time.contact_s;
  if (criterion.measure == "rest_s") return time.rest_s;
  if (criterion.measure == "time_ratio") return score.trainee_s / score.expert_s;
  if (criterion.measure == "sites_right_share") return ShareRight(criteria, grade.depths);
  static const std::map<std::string, double Score::*> kOfScore = {
      {"force_peak_N", &Score::trainee_peak_N},
      {"force_rms_N", &Score::force_rms_N},
      {"path_mean_mm", &Score::path_mean_mm},
      {"path_max_mm", &Score::path_max_mm},
      {"turn_mean_deg", &Score::turn_mean_deg}};
  return score.*kOfScore.at(criterion.measure);
}

}  // namespace

std::optional<double> DepthIn(const ProbingSite& site, const Vec3& tip, const HandPath& path) {
  std::optional<double> deepest;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (!path.touches(i)) continue;
    const Pose& X = path.tool()[i];
    const Vec3 from_margin = X.p + X.q * tip - site.margin;
    const double depth = from_margin.dot(site.into);
    if (depth <= 0.0 || (from_margin - depth * site.into).norm() > site.radius) continue;
    deepest = std::max(deepest.value_or(0.0), depth);
  }
  return deepest;
}

std::optional<double> MeasureCut(const Criterion& criterion, const SolidsCut& expert,
                                 const SolidsCut& trial, const CutShape& shape,
                                 const std::string& file) {
  const std::string& measure = criterion.measure;
  if (measure == "thickness_mm") {
    try {
      return shape.ThicknessOver(criterion.tissue, criterion.place);
    } catch (const Error& error) {
      throw Error(file + ": criterion '" + criterion.name + "': " + error.what());
    }
  }
  if (measure == "missed_mm3" || measure == "excess_mm3") {
    const TargetDifference difference =
        DifferenceTo(expert, trial, criterion.tissue, criterion.place);
    return measure == "missed_mm3" ? difference.missed_mm3 : difference.excess_mm3;
  }
  if (!MeasureOf(measure).along_axis) return OfTissue(criterion, trial, shape, file);
  const Preparation found = shape.PreparationAlong(criterion.axis, criterion.place);
  const auto where = [](const std::optional<double>& there, double value) {
    return there ? std::optional(value) : std::nullopt;
  };
  if (measure == "taper_deg") return found.taper_deg;
  if (measure == "undercut_share") return where(found.taper_deg, found.undercut_share);
  if (measure == "margin_width_mm") return found.width_mm;
  if (measure == "margin_spread_mm") return where(found.width_mm, found.spread_mm);
  return where(found.width_mm, found.roughness_mm);
}

std::optional<Grade> GradeTrial(const Criteria& criteria, const Score& score,
                                const HandPath& trainee, const MeasureOfCut& of_cut) {
  if (score.trainee_contact_s == 0.0) return std::nullopt;
  Grade grade;
  for (const ProbingSite& site : criteria.sites) {
    grade.depths.push_back(DepthIn(site, criteria.tip, trainee));
  }
  for (const Criterion& criterion : criteria.criteria) {
    const auto value = ValueOf(criterion, criteria, score, trainee, of_cut, grade);
    const double share =
        (value.value_or(criterion.worst) - criterion.worst) / (criterion.best - criterion.worst);
    grade.marks.push_back({value, 100.0 * std::min(1.0, std::max(0.0, share))});  // not -0
    if (criterion.gates) grade.done *= 0.01 * grade.marks.back().ungated;
    if (criterion.harms) grade.harmless *= 0.01 * grade.marks.back().ungated;
  }
  double weights = 0.0;
  for (std::size_t c = 0; c < grade.marks.size(); ++c) {
    const Criterion& criterion = criteria.criteria[c];
    Grade::Mark& mark = grade.marks[c];
    mark.points = (criterion.gates ? 1.0 : grade.done) * (criterion.harms ? 1.0 : grade.harmless) *
                  mark.ungated;
    grade.points += criterion.weight * mark.points;
    weights += criterion.weight;
  }
  grade.points /= weights;
  return grade;
}

}  // namespace palpate
