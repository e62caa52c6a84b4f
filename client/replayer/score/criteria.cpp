#include "client/replayer/score/criteria.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "common/json/json_file.h"

namespace palpate {
namespace {

std::vector<std::string_view> MeasureNames() {
  std::vector<std::string_view> names;
  for (const Measure& measure : kMeasures) names.emplace_back(measure.name);
  return names;
}

/// Of the time with the tool's tip in the criterion's place.
struct TimeThere {
  double all_s = 0.0, contact_s = 0.0;
  double over_s = 0.0;  ///< with more force than the limit
};
TimeThere TimeIn(const Criterion& criterion, const Vec3& tip, const HandPath& path) {
  TimeThere time;
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (criterion.place && !criterion.place->Holds(path.tool()[i] * tip)) continue;
    const double step_s = path.time_s[i] - path.time_s[i - 1];
    time.all_s += step_s;
    if (path.touches(i)) time.contact_s += step_s;
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

double OfTissue(const Criterion& criterion, const SolidsCut& trial, const std::string& file) {
  const std::vector<TissueCut> cut = TissuesOf(trial, criterion.place);
  const auto tissue = std::ranges::find(cut, criterion.tissue, &TissueCut::name);
  if (tissue == cut.end()) {
    std::string names;
    for (const TissueCut& one : cut) names += (names.empty() ? "" : ", ") + one.name;
    throw Error(file + ": criterion '" + criterion.name + "': nothing that is cut is called '" +
                criterion.tissue + "'; " +
                (names.empty() ? "the scene has no solid" : "there is: " + names));
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
  if (criterion.measure == "time_ratio") return score.trainee_s / score.expert_s;
  if (criterion.measure == "sites_right_share") return ShareRight(criteria, grade.depths);
  return score.*MeasureOf(criterion.measure).of_score;
}

Vec3 ReadDirection(const JsonNode& node) {
  const Vec3 direction = node.Vector();
  if (!(direction.norm() > 1e-6)) node.Fail("is no direction; give one that is not 0");
  return direction.normalized();
}

MaterialRegion ReadPlace(const JsonNode& node) {
  node.AllowOnly({"box", "sphere"});
  const auto box = node.Find("box"), sphere = node.Find("sphere");
  if (box.has_value() == sphere.has_value()) {
    node.Fail("must be one place; give \"box\" or \"sphere\"");
  }
  MaterialRegion place;
  if (box) {
    box->AllowOnly({"min_mm", "max_mm"});
    place.low = 1e-3 * box->At("min_mm").Vector();
    place.high = 1e-3 * box->At("max_mm").Vector();
    if (!(place.low.array() < place.high.array()).all()) {
      box->Fail("is empty; each entry of min_mm must be below max_mm's");
    }
  } else {
    sphere->AllowOnly({"centre_mm", "radius_mm"});
    place.low = 1e-3 * sphere->At("centre_mm").Vector();
    place.radius = 1e-3 * sphere->At("radius_mm").PositiveNumber();
  }
  return place;
}

/// What goes with some measures alone.
void ReadWhatItIsAbout(const JsonNode& node, Criterion& criterion) {
  const Measure& measure = MeasureOf(criterion.measure);
  const auto refuse = [&](const JsonNode& field) {
    field.Fail("does not go with \"" + criterion.measure + "\"; drop it");
  };
  if (criterion.measure == "force_over_share") {
    criterion.limit_N = node.At("limit_N").PositiveNumber();
  } else if (auto limit = node.Find("limit_N")) {
    refuse(*limit);
  }
  const auto tissue = measure.tissue == Measure::Tissue::kMustName
                          ? std::optional(node.At("tissue"))
                          : node.Find("tissue");
  if (tissue && measure.tissue == Measure::Tissue::kNone) refuse(*tissue);
  if (tissue) criterion.tissue = tissue->String();
  if (auto axis = node.Find("axis")) {
    if (!measure.along_axis) refuse(*axis);
    criterion.axis = ReadDirection(*axis);
  }
  if (auto place = node.Find("region")) {
    if (!measure.in_a_place) refuse(*place);
    criterion.place = ReadPlace(*place);
  }
}

Criterion ReadCriterion(const JsonNode& node, bool has_sites) {
  node.AllowOnly(
      {"name", "why", "measure", "limit_N", "tissue", "axis", "region", "best", "worst", "weight"});
  Criterion criterion;
  criterion.name = node.At("name").String();
  if (auto why = node.Find("why")) criterion.why = why->String();
  criterion.measure = node.At("measure").OneOf(MeasureNames());
  ReadWhatItIsAbout(node, criterion);
  if (criterion.measure == "sites_right_share" && !has_sites) {
    node.At("measure").Fail("needs \"sites\"; add them, or take another measure");
  }
  criterion.best = node.At("best").Number();
  criterion.worst = node.At("worst").Number();
  if (criterion.best == criterion.worst) {
    node.At("worst").Fail("is the same as best; give another number");
  }
  if (auto weight = node.Find("weight")) criterion.weight = weight->PositiveNumber();
  return criterion;
}

ProbingSite ReadSite(const JsonNode& node) {
  node.AllowOnly({"name", "margin_mm", "into", "radius_mm", "depth_mm", "tolerance_mm"});
  ProbingSite site;
  site.name = node.At("name").String();
  site.margin = 1e-3 * node.At("margin_mm").Vector();
  site.into = ReadDirection(node.At("into"));
  site.radius = 1e-3 * node.At("radius_mm").PositiveNumber();
  site.depth = 1e-3 * node.At("depth_mm").PositiveNumber();
  site.tolerance = 1e-3 * node.At("tolerance_mm").PositiveNumber();
  return site;
}

}  // namespace

using Tissue = Measure::Tissue;
const std::vector<Measure> kMeasures = {
    {.name = "force_over_share",
     .unit = "%",
     .text = "share of the time in contact with more force than the limit",
     .in_a_place = true},
    {"force_peak_N", "N", "greatest force", &Score::trainee_peak_N},
    {"force_rms_N", "N", "difference of the force from the expert's (rms)", &Score::force_rms_N},
    {"path_mean_mm", "mm", "mean distance from the expert's path", &Score::path_mean_mm},
    {"path_max_mm", "mm", "greatest distance from the expert's path", &Score::path_max_mm},
    {"turn_mean_deg", "°", "mean difference of rotation", &Score::turn_mean_deg},
    {.name = "time_s", .unit = "s", .text = "time taken", .in_a_place = true},
    {"time_ratio", "×", "time taken, as a multiple of the expert's"},
    {"sites_right_share", "%", "share of the sites whose depth was probed rightly"},
    {"removed_mm3", "mm³", "removed by the bur", nullptr, Tissue::kMustName, true},
    {"left_share", "%", "share that the bur left", nullptr, Tissue::kMustName, true},
    {"missed_mm3", "mm³", "gone at the expert's and still there", nullptr, Tissue::kMayName, true},
    {"excess_mm3", "mm³", "there at the expert's and gone", nullptr, Tissue::kMayName, true},
    {"thickness_mm", "mm", "least thickness left over a tissue", nullptr, Tissue::kMustName, true},
    {"taper_deg", "°", "angle of the walls to the axis", nullptr, Tissue::kNone, true, true},
    {"undercut_share", "%", "share of the walls that are undercut", nullptr, Tissue::kNone, true,
     true},
    {"margin_width_mm", "mm", "width of the shoulder at the border", nullptr, Tissue::kNone, true,
     true},
    {"margin_spread_mm", "mm", "how the width of the shoulder varies (standard deviation)", nullptr,
     Tissue::kNone, true, true},
    {"margin_roughness_mm", "mm", "unevenness of the border (rms)", nullptr, Tissue::kNone, true,
     true},
};

const Measure& MeasureOf(const std::string& name) {
  return *std::ranges::find_if(kMeasures, [&](const Measure& m) { return name == m.name; });
}

const char* const kCriteriaToBeginWith =
    R"({
  // What palpate-replay score grades by.  Change what you like; comments are allowed.
  "title": "Periodontal probing",
  "pass": 70,                            // of 100 points
  "tip_mm": [0, 0, 0],                   // of the tool, in its own frame
  // "best" earns all of a criterion's points, "worst" none, what lies between its share.
  // Measures: force_over_share, force_peak_N, force_rms_N, path_mean_mm, path_max_mm,
  // turn_mean_deg, time_s, time_ratio, sites_right_share; of what a bur cuts, with "tissue":
  // removed_mm3, left_share, thickness_mm, missed_mm3, excess_mm3; of a preparation along "axis":
  // taper_deg, undercut_share, margin_width_mm, margin_spread_mm, margin_roughness_mm.  Shares are
  // from 0 to 1.
  "criteria": [
    {"name": "No more than 25 g", "measure": "force_over_share", "limit_N": 0.245,
     "best": 0, "worst": 0.5, "weight": 2,
     "why": "25 g on the probe find the bottom of a pocket; more hurts, and goes through it"},
    {"name": "Depths found", "measure": "sites_right_share", "best": 1, "worst": 0, "weight": 2,
     "why": "Within 1 mm, as far apart as two examiners are"},
    {"name": "The expert's way", "measure": "path_mean_mm", "best": 1, "worst": 8}
  ],
  // Depth counts from margin_mm along "into", both in the scene's frame, as far as the tip stays
  // within radius_mm of that line.
  "sites": [
    {"name": "36 buccal", "margin_mm": [2.2, 0, 4.6], "into": [0, -1, -0.25], "radius_mm": 2.5,
     "depth_mm": 6, "tolerance_mm": 1}
  ]
}
)";

Criteria LoadCriteria(const std::string& file) {
  const JsonNode root = JsonNode::Load(file);
  root.AllowOnly({"title", "pass", "tip_mm", "criteria", "sites"});
  Criteria criteria;
  criteria.file = file;
  criteria.title = root.At("title").String();
  criteria.pass = root.At("pass").Number(0.0, 100.0);
  if (auto tip = root.Find("tip_mm")) criteria.tip = 1e-3 * tip->Vector();
  if (auto sites = root.Find("sites")) {
    for (const JsonNode& site : sites->Items()) criteria.sites.push_back(ReadSite(site));
  }
  for (const JsonNode& node : root.At("criteria").Items(1)) {
    criteria.criteria.push_back(ReadCriterion(node, !criteria.sites.empty()));
  }
  return criteria;
}

std::optional<double> DepthIn(const ProbingSite& site, const Vec3& tip, const HandPath& path) {
  std::optional<double> deepest;
  for (const Pose& X : path.tool()) {
    const Vec3 from_margin = X.p + X.q * tip - site.margin;
    const double depth = from_margin.dot(site.into);
    if (depth <= 0.0 || (from_margin - depth * site.into).norm() > site.radius) continue;
    deepest = std::max(deepest.value_or(0.0), depth);
  }
  return deepest;
}

bool AsksForCuts(const Criteria& criteria) {
  return std::ranges::any_of(criteria.criteria, [](const Criterion& criterion) {
    return MeasureOf(criterion.measure).of_cut;
  });
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
  if (!MeasureOf(measure).along_axis) return OfTissue(criterion, trial, file);
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
  double weights = 0.0;
  for (const Criterion& criterion : criteria.criteria) {
    const auto value = ValueOf(criterion, criteria, score, trainee, of_cut, grade);
    const double share =
        (value.value_or(criterion.worst) - criterion.worst) / (criterion.best - criterion.worst);
    grade.marks.push_back({value, 100.0 * std::clamp(share, 0.0, 1.0)});
    grade.points += criterion.weight * grade.marks.back().points;
    weights += criterion.weight;
  }
  grade.points /= weights;
  return grade;
}

}  // namespace palpate
