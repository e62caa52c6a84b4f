#include "client/course/criteria_file.h"

#include <algorithm>

#include <spdlog/fmt/fmt.h>

#include "common/text/joined.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

std::vector<std::string_view> MeasureNames() {
  std::vector<std::string_view> names;
  for (const Measure& measure : kMeasures) names.emplace_back(measure.name);
  return names;
}

Vec3 ReadDirection(const JsonNode& node) {
  const Vec3 direction = node.Vector();
  if (!(direction.norm() > 1e-6)) node.Fail("has length 0; give a direction");
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

/// Reads the fields that only some measures have.
void ReadWhatItIsAbout(const JsonNode& node, Criterion& criterion) {
  const Measure& measure = MeasureOf(criterion.measure);
  const auto refuse = [&](const JsonNode& field) {
    field.Fail("does not apply to measure \"" + criterion.measure + "\"; drop it");
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
  criterion.names = ReadLocalText(node.At("name"));
  criterion.name = EnglishOf(criterion.names);
  if (auto why = node.Find("why")) criterion.why = ReadLocalText(*why);
  criterion.measure = node.At("measure").OneOf(MeasureNames());
  ReadWhatItIsAbout(node, criterion);
  if (criterion.measure == "sites_right_share" && !has_sites) {
    node.At("measure").Fail("needs \"sites\"; add them, or use another measure");
  }
  criterion.best = node.At("best").Number();
  criterion.worst = node.At("worst").Number();
  if (criterion.best == criterion.worst) {
    node.At("worst").Fail("is the same as best; give another number");
  }
  if (auto weight = node.Find("weight")) criterion.weight = weight->PositiveNumber();
  return criterion;
}

/// Marks the criteria that a list of names calls gates, or harms.
void MarkNamed(const JsonNode& names, bool Criterion::*as, std::vector<Criterion>& criteria) {
  for (const JsonNode& name : names.Items(1)) {
    const auto count = std::ranges::count(criteria, name.String(), &Criterion::name);
    if (count != 1) {
      name.Fail(fmt::format("{} is the name of {} criteria; give one of: {}", Quoted(name.String()),
                            count, Joined(criteria, &Criterion::name)));
    }
    Criterion& named = *std::ranges::find(criteria, name.String(), &Criterion::name);
    named.*as = true;
    if (named.gates && named.harms) name.Fail("is named in \"gates\" too; drop it from one");
  }
  if (std::ranges::all_of(criteria, as)) {
    names.Fail(
        "names all criteria, so nothing is left to count only as far as they are met; drop some, "
        "or drop the field");
  }
}

ProbingSite ReadSite(const JsonNode& node) {
  node.AllowOnly({"name", "margin_mm", "into", "radius_mm", "depth_mm", "tolerance_mm"});
  ProbingSite site;
  site.names = ReadLocalText(node.At("name"));
  site.name = EnglishOf(site.names);
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
    {.name = "force_over_share", .unit = "%", .in_a_place = true},
    {"force_peak_N", "N"},
    {"force_rms_N", "N"},
    {"path_mean_mm", "mm"},
    {"path_max_mm", "mm"},
    {"turn_mean_deg", "°"},
    {.name = "time_s", .unit = "s", .in_a_place = true},
    {.name = "contact_s", .unit = "s", .in_a_place = true},
    {.name = "rest_s", .unit = "s", .in_a_place = true},
    {"time_ratio", "×"},
    {"sites_right_share", "%"},
    {"removed_mm3", "mm³", Tissue::kMustName, true},
    {"left_share", "%", Tissue::kMustName, true},
    {"missed_mm3", "mm³", Tissue::kMayName, true},
    {"excess_mm3", "mm³", Tissue::kMayName, true},
    {"thickness_mm", "mm", Tissue::kMustName, true},
    {"taper_deg", "°", Tissue::kNone, true, true},
    {"undercut_share", "%", Tissue::kNone, true, true},
    {"margin_width_mm", "mm", Tissue::kNone, true, true},
    {"margin_spread_mm", "mm", Tissue::kNone, true, true},
    {"margin_roughness_mm", "mm", Tissue::kNone, true, true},
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
  // turn_mean_deg, time_s, contact_s, rest_s, time_ratio, sites_right_share; of what is cut, with
  // "tissue": removed_mm3, left_share, thickness_mm, missed_mm3, excess_mm3; of a preparation along
  // "axis": taper_deg, undercut_share, margin_width_mm, margin_spread_mm, margin_roughness_mm.
  // Shares are from 0 to 1.
  "criteria": [
    {"name": "No more than 25 g", "measure": "force_over_share", "limit_N": 0.245,
     "best": 0, "worst": 0.5, "weight": 2,
     "why": "25 g on the probe find the bottom of a pocket; more hurts, and goes through it"},
    {"name": "Depths found", "measure": "sites_right_share", "best": 1, "worst": 0, "weight": 2,
     "why": "Within 1 mm, as far apart as two examiners are"},
    {"name": "The expert's way", "measure": "path_mean_mm", "best": 1, "worst": 8}
  ],
  // Who does little does little wrong: the other criteria count only as far as these are met.
  "gates": ["Depths found"],
  // Depth counts from margin_mm along "into", both in the scene's frame, as far as the tip stays
  // within radius_mm of that line.
  "sites": [
    {"name": "36 buccal", "margin_mm": [2.2, 0, 4.6], "into": [0, -1, -0.25], "radius_mm": 2.5,
     "depth_mm": 6, "tolerance_mm": 1}
  ]
}
)";

bool AsksForCuts(const Criteria& criteria) {
  return std::ranges::any_of(criteria.criteria, [](const Criterion& criterion) {
    return MeasureOf(criterion.measure).of_cut;
  });
}

Criteria ReadCriteria(const JsonNode& root, const std::string& file, const LocalText& title) {
  root.AllowOnly({"title", "pass", "tip_mm", "criteria", "gates", "harms", "sites"});
  Criteria criteria;
  criteria.file = file;
  criteria.titles = title.empty() || root.Has("title") ? ReadLocalText(root.At("title")) : title;
  criteria.title = EnglishOf(criteria.titles);
  criteria.pass = root.At("pass").Number(0.0, 100.0);
  if (auto tip = root.Find("tip_mm")) criteria.tip = 1e-3 * tip->Vector();
  if (auto sites = root.Find("sites")) {
    for (const JsonNode& site : sites->Items()) criteria.sites.push_back(ReadSite(site));
  }
  for (const JsonNode& node : root.At("criteria").Items(1)) {
    criteria.criteria.push_back(ReadCriterion(node, !criteria.sites.empty()));
  }
  if (auto gates = root.Find("gates")) MarkNamed(*gates, &Criterion::gates, criteria.criteria);
  if (auto harms = root.Find("harms")) MarkNamed(*harms, &Criterion::harms, criteria.criteria);
  return criteria;
}

}  // namespace palpate
