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

/// Of the time in contact, the share with more force than that.
double ShareOver(double limit_N, const HandPath& path) {
  double contact_s = 0.0, over_s = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double step_s = path.time_s[i] - path.time_s[i - 1];
    if (path.touches(i)) contact_s += step_s;
    if (path.force_N[i].norm() > limit_N) over_s += step_s;
  }
  return contact_s > 0.0 ? over_s / contact_s : 0.0;
}

double ShareRight(const Criteria& criteria, const std::vector<std::optional<double>>& depths) {
  std::size_t right = 0;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const ProbingSite& site = criteria.sites[i];
    right += depths[i] && std::abs(*depths[i] - site.depth) <= site.tolerance;
  }
  return static_cast<double>(right) / static_cast<double>(std::max<std::size_t>(1, depths.size()));
}

double OfTissue(const Criterion& criterion, const std::string& file,
                const std::vector<TissueCut>& cut) {
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

double ValueOf(const Criterion& criterion, const Criteria& criteria, const Score& score,
               const HandPath& trainee, const std::vector<TissueCut>& cut, const Grade& grade) {
  if (MeasureOf(criterion.measure).of_tissue) return OfTissue(criterion, criteria.file, cut);
  if (criterion.measure == "force_over_share") return ShareOver(criterion.limit_N, trainee);
  if (criterion.measure == "time_ratio") return score.trainee_s / score.expert_s;
  if (criterion.measure == "sites_right_share") return ShareRight(criteria, grade.depths);
  return score.*MeasureOf(criterion.measure).of_score;
}

Criterion ReadCriterion(const JsonNode& node, bool has_sites) {
  node.AllowOnly({"name", "why", "measure", "limit_N", "tissue", "best", "worst", "weight"});
  Criterion criterion;
  criterion.name = node.At("name").String();
  if (auto why = node.Find("why")) criterion.why = why->String();
  criterion.measure = node.At("measure").OneOf(MeasureNames());
  const bool over = criterion.measure == "force_over_share";
  if (over) {
    criterion.limit_N = node.At("limit_N").PositiveNumber();
  } else if (auto limit = node.Find("limit_N")) {
    limit->Fail("goes with \"force_over_share\" alone; drop it");
  }
  if (MeasureOf(criterion.measure).of_tissue) {
    criterion.tissue = node.At("tissue").String();
  } else if (auto tissue = node.Find("tissue")) {
    tissue->Fail("goes with \"removed_mm3\" and \"left_share\" alone; drop it");
  }
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
  const JsonNode into = node.At("into");
  site.into = into.Vector();
  if (!(site.into.norm() > 1e-6)) into.Fail("is no direction; give one that is not 0");
  site.into.normalize();
  site.radius = 1e-3 * node.At("radius_mm").PositiveNumber();
  site.depth = 1e-3 * node.At("depth_mm").PositiveNumber();
  site.tolerance = 1e-3 * node.At("tolerance_mm").PositiveNumber();
  return site;
}

}  // namespace

const std::vector<Measure> kMeasures = {
    {"force_over_share", "%", "share of the time in contact with more force than the limit"},
    {"force_peak_N", "N", "greatest force", &Score::trainee_peak_N},
    {"force_rms_N", "N", "difference of the force from the expert's (rms)", &Score::force_rms_N},
    {"path_mean_mm", "mm", "mean distance from the expert's path", &Score::path_mean_mm},
    {"path_max_mm", "mm", "greatest distance from the expert's path", &Score::path_max_mm},
    {"turn_mean_deg", "°", "mean difference of rotation", &Score::turn_mean_deg},
    {"time_ratio", "×", "time taken, as a multiple of the expert's"},
    {"sites_right_share", "%", "share of the sites whose depth was probed rightly"},
    {"removed_mm3", "mm³", "removed by the bur", nullptr, true},
    {"left_share", "%", "share that the bur left", nullptr, true},
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
  // turn_mean_deg, time_ratio, sites_right_share; of what a bur cuts, with "tissue": removed_mm3,
  // left_share.  Shares are from 0 to 1.
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
    return MeasureOf(criterion.measure).of_tissue;
  });
}

std::optional<Grade> GradeTrial(const Criteria& criteria, const Score& score,
                                const HandPath& trainee, const std::vector<TissueCut>& cut) {
  if (score.trainee_contact_s == 0.0) return std::nullopt;
  Grade grade;
  for (const ProbingSite& site : criteria.sites) {
    grade.depths.push_back(DepthIn(site, criteria.tip, trainee));
  }
  double weights = 0.0;
  for (const Criterion& criterion : criteria.criteria) {
    const double value = ValueOf(criterion, criteria, score, trainee, cut, grade);
    const double share = (value - criterion.worst) / (criterion.best - criterion.worst);
    grade.marks.push_back({value, 100.0 * std::clamp(share, 0.0, 1.0)});
    grade.points += criterion.weight * grade.marks.back().points;
    weights += criterion.weight;
  }
  grade.points /= weights;
  return grade;
}

}  // namespace palpate
