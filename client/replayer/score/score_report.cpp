#include "client/replayer/score/score_report.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <functional>
#include <numeric>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include "client/replayer/hand_path.h"
#include "client/replayer/score/performance.h"
#include "client/replayer/score/score_words.h"
#include "client/replayer/score/trial_cut.h"
#include "common/error.h"
#include "common/files/output.h"
#include "common/files/whole_file.h"
#include "common/json/json_file.h"
#include "common/text/joined.h"
#include "common/text/quoted.h"
#include "scenes/catalogue.h"
#include "server/physics/scene_model.h"

namespace palpate {
namespace {

/// Points of a path on the page: more would not show on a screen.
constexpr std::size_t kMostShown = 600;

constexpr const char* kOneTrial =
    "One trial predicts nothing: give several, and go by their average.";
/// Ending of a hand's script.
constexpr std::string_view kScriptEnding = ".path.json";
constexpr const char* kUntouched = "nothing was touched";
/// A loaded host leaves some poses unanswered; of more than this the score would be a guess.
constexpr double kMostUnanswered = 0.05;

/// A figure listed for each trial beside its marks.
struct Figure {
  const char* key;  ///< of score_words.h
  const char* name;
  const char* unit;
  int digits;
  double Score::*trainee;
  double Score::*expert;  ///< none: the figure is a difference from the expert
};
constexpr Figure kFigures[] = {
    {"figure.time", "Time", "s", 2, &Score::trainee_s, &Score::expert_s},
    {"figure.contact", "Time in contact", "s", 3, &Score::trainee_contact_s,
     &Score::expert_contact_s},
    {"figure.peak", "Greatest force", "N", 3, &Score::trainee_peak_N, &Score::expert_peak_N},
    {"figure.path_mean", "Distance of the paths, mean", "mm", 2, &Score::path_mean_mm, nullptr},
    {"figure.path_max", "Distance of the paths, greatest", "mm", 2, &Score::path_max_mm, nullptr},
    {"figure.frechet", "Distance of the paths, Fréchet", "mm", 2, &Score::frechet_mm, nullptr},
    {"figure.turn", "Difference of rotation, mean", "°", 1, &Score::turn_mean_deg, nullptr},
    {"figure.force_rms", "Difference of force, rms", "N", 3, &Score::force_rms_N, nullptr},
};

std::vector<double> Each(const Report& report, const std::function<double(std::size_t)>& of) {
  std::vector<double> values;
  for (std::size_t i = 0; i < report.trials.size(); ++i) values.push_back(of(i));
  return values;
}

std::string ToText(const Average& average, int digits, const char* unit = "") {
  std::string text = fmt::format("{:.{}f}", average.mean, digits);
  if (average.deviation > 0.0) text += fmt::format(" ± {:.{}f}", average.deviation, digits);
  return *unit == '\0' ? text : text + " " + unit;
}

/// Returns the value in the measure's own unit; shares in per cent.
double Shown(const Criterion& criterion, double value) {
  return MeasureOf(criterion.measure).unit == std::string("%") ? 100.0 * value : value;
}

/// Returns the mean of the trials that have a grade; nothing if none has.
std::optional<Average> AverageGrade(const Report& report,
                                    const std::function<double(const Grade&)>& of) {
  std::vector<double> values;
  for (const auto& grade : report.grades) {
    if (grade) values.push_back(of(*grade));
  }
  if (values.empty()) return std::nullopt;
  return AverageOf(values);
}
std::optional<Average> PointsOf(const Report& report) {
  return AverageGrade(report, [](const Grade& grade) { return grade.points; });
}

std::string WhyIncomplete(const Trial& trial) {
  return Joined(trial.incomplete, EnglishOf, "; ");
}

/// A value in the braces of a text.
Said With(const char* name, const std::string& value) {
  return {name, {{{"en", value}}}};
}
Said With(const char* name, double value) {
  return With(name, fmt::format("{:.0f}", value));
}

LocalText NamesOf(const Criterion& criterion) {
  return criterion.names.empty() ? LocalText{{"en", criterion.name}} : criterion.names;
}

/// What takes points from other criteria: a task that is not done, or harm.
struct Taker {
  double Grade::*share;
  bool Criterion::*named;
  const char* key;  ///< of its sentence
};
constexpr Taker kTakers[] = {{&Grade::done, &Criterion::gates, "gated"},
                             {&Grade::harmless, &Criterion::harms, "harmed"}};

/// Returns in sentences what has taken points from other criteria, as `say` writes them.
std::vector<std::string> TakenTexts(const Report& report,
                                    std::string (*say)(const std::string&, const Values&)) {
  std::vector<std::string> texts;
  for (const Taker& taker : kTakers) {
    const auto share =
        AverageGrade(report, [&](const Grade& grade) { return 100.0 * grade.*taker.share; });
    if (!share || share->mean > 99.5) continue;
    Said names{"criteria", {}};
    for (const Criterion& criterion : report.criteria->criteria) {
      if (criterion.*taker.named) names.values.push_back(NamesOf(criterion));
    }
    texts.push_back(say(taker.key, {With("share", share->mean), names}));
  }
  return texts;
}

/// Returns JSON as an expression for a script element.  HTML ends a script at "</script", but not
/// after "<!--<script", so <, > and & are escaped; they only occur in JSON strings.
std::string Embedded(const nlohmann::ordered_json& json) {
  std::string script;
  for (const char c : json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace)) {
    script += c == '<'   ? "\\u003c"
              : c == '>' ? "\\u003e"
              : c == '&' ? "\\u0026"
                         : std::string(1, c);
  }
  return script;
}

/// Returns the name of a recording in a report, as the heading of a column.
/// @param station  as chosen; empty: none was.
std::string NameOf(const std::string& file, const std::string& station) {
  constexpr std::size_t kMost = 60;
  const std::string all = Printable(std::filesystem::path(file).stem().string());
  std::string name(BeginningOf(all, kMost));
  if (name.size() < all.size()) name += "…";
  return station.empty() ? name : name + " (" + station + ")";
}

std::string Cell(const std::string& text) {
  return "<td>" + text + "</td>";
}

/// @param before  keys of the columns before the trials'; "": without a heading
std::string HeadRow(const Report& report, const std::vector<std::string>& before) {
  std::string row = "<tr>";
  for (const std::string& key : before) row += "<th>" + (key.empty() ? "" : Say(key)) + "</th>";
  for (const Trial& trial : report.trials) row += "<th>" + Escaped(trial.name) + "</th>";
  return row + (report.trials.size() > 1 ? "<th>" + Say("average") + "</th></tr>\n" : "</tr>\n");
}

std::string AverageCell(const Report& report, const std::optional<Average>& average, int digits) {
  if (report.trials.size() == 1) return "";
  return Cell(average ? ToText(*average, digits) : "");
}

std::string VerdictHtml(const Report& report) {
  if (!report.criteria) return "<p class=\"quiet\">" + Say("no_grade") + "</p>\n";
  const auto points = PointsOf(report);
  if (!points) return "<p class=\"verdict poor\">" + Say("no_points") + "</p>\n";
  const bool passed = Passed(report);
  const auto graded =
      std::ranges::count_if(report.grades, [](const auto& grade) { return grade.has_value(); });
  const Said enough = With("points", report.criteria->pass);
  const std::string of = graded > 1
                             ? Say("average_of", {With("count", double(graded)),
                                                  With("deviation", points->deviation), enough})
                             : Say("enough", {enough});
  std::string html = fmt::format(
      "<p class=\"verdict {}\"><b>{:.0f}</b><span class=\"word\">{}</span><span "
      "class=\"quiet\">{}</span></p>\n",
      passed ? "good" : "poor", points->mean, Say(passed ? "passed" : "not_yet"), of);
  for (const std::string& text : TakenTexts(report, &Say)) {
    html += "<p class=\"poor\">" + text + "</p>\n";
  }
  return html;
}

/// Returns a tissue's name in the reader's language, if it is a usual one.
std::string TissueHtml(const std::string& name) {
  const std::string key = "tissue." + name;
  return KeyAttribute(key).empty() ? Escaped(name) : Say(key);
}

/// Returns what a criterion measures, and why.
std::string WhatHtml(const Criterion& criterion) {
  std::string what = Say("measure." + criterion.measure);
  if (criterion.limit_N > 0.0) what += fmt::format(", {:g} N", criterion.limit_N);
  if (!criterion.tissue.empty()) what += ": " + TissueHtml(criterion.tissue);
  if (criterion.place) what += Say("in_a_region");
  if (criterion.gates) what += Say("is_the_task");
  if (criterion.harms) what += Say("is_a_harm");
  if (!criterion.why.empty()) what += ". " + Say(criterion.why, "");
  return what;
}

std::string MarksHtml(const Report& report) {
  const Criteria& criteria = *report.criteria;
  std::string html = "<h2>" + Say("marks") + "</h2>\n<div class=\"wide\"><table>\n" +
                     HeadRow(report, {"criterion", "best_worst", "weight"});
  for (std::size_t c = 0; c < criteria.criteria.size(); ++c) {
    const Criterion& criterion = criteria.criteria[c];
    const Measure& measure = MeasureOf(criterion.measure);
    html += "<tr>" + Cell(Say(criterion.names, criterion.name) + "<small>" + WhatHtml(criterion) +
                          "</small>");
    html += Cell(fmt::format("{:g} – {:g} {}", Shown(criterion, criterion.best),
                             Shown(criterion, criterion.worst), measure.unit)) +
            Cell(fmt::format("{:g}", criterion.weight));
    for (const auto& grade : report.grades) {
      if (!grade) {
        html += Cell("");
        continue;
      }
      const Grade::Mark& mark = grade->marks[c];
      html +=
          Cell((mark.value ? fmt::format("{:.3g} {}", Shown(criterion, *mark.value), measure.unit)
                           : Say("nothing_to_measure")) +
               "<br><span class=\"points\">" + Say("mark_points", {With("points", mark.points)}) +
               "</span>" +
               (mark.points < mark.ungated - 0.5
                    ? "<small>" +
                          Say("gated_points", {With("points", mark.ungated),
                                               With("share", 100.0 * mark.points / mark.ungated)}) +
                          "</small>"
                    : ""));
    }
    html += AverageCell(
        report, AverageGrade(report, [&](const Grade& grade) { return grade.marks[c].points; }), 0);
    html += "</tr>\n";
  }
  html += "<tr class=\"sum\">" + Cell(Say("points_row")) + Cell("") + Cell("");
  for (const auto& grade : report.grades) {
    html += Cell(grade ? fmt::format("{:.0f}", grade->points) : Say("untouched"));
  }
  return html + AverageCell(report, PointsOf(report), 0) + "</tr>\n</table></div>\n";
}

std::string SitesHtml(const Report& report) {
  const std::vector<ProbingSite>& sites = report.criteria->sites;
  if (sites.empty()) return "";
  std::string html = "<h2>" + Say("depths") + "</h2>\n<div class=\"wide\"><table>\n" +
                     HeadRow(report, {"site", "right"});
  for (std::size_t s = 0; s < sites.size(); ++s) {
    html += "<tr>" + Cell(Say(sites[s].names, sites[s].name)) +
            Cell(fmt::format("{:.1f} ± {:.1f} mm", 1e3 * sites[s].depth, 1e3 * sites[s].tolerance));
    std::vector<double> found;
    for (const auto& grade : report.grades) {
      const std::optional<double> depth = grade ? grade->depths[s] : std::nullopt;
      if (!depth) {
        html += "<td class=\"poor\">" + Say("not_probed") + "</td>";
        continue;
      }
      found.push_back(1e3 * *depth);
      const bool right = std::abs(*depth - sites[s].depth) <= sites[s].tolerance;
      html += fmt::format("<td class=\"{}\">{:.1f} mm</td>", right ? "good" : "poor", 1e3 * *depth);
    }
    if (report.trials.size() > 1) {
      html += Cell(found.empty() ? "" : ToText(AverageOf(found), 1, "mm"));
    }
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string FiguresHtml(const Report& report) {
  std::string html = "<h2>" + Say("figures") + "</h2>\n<div class=\"wide\"><table>\n" +
                     HeadRow(report, {"", "expert"});
  for (const Figure& figure : kFigures) {
    const Score& first = report.trials.front().score;
    html += "<tr>" + Cell(Say(figure.key)) +
            Cell(figure.expert ? fmt::format("{:.{}f}", first.*figure.expert, figure.digits) : "");
    const std::vector<double> values =
        Each(report, [&](std::size_t i) { return report.trials[i].score.*figure.trainee; });
    for (const double value : values) html += Cell(fmt::format("{:.{}f}", value, figure.digits));
    html += AverageCell(report, AverageOf(values), figure.digits) + "</tr>\n";
  }
  return html + "</table></div>\n";
}

/// Returns the trial's tissue that the expert's report names; both are of the same scene.
const TissueCut& TissueOf(const std::vector<TissueCut>& cut, const std::string& name) {
  return *std::ranges::find(cut, name, &TissueCut::name);
}

/// Returns the element in which score_cut.js draws; the trials' pictures come after the expert's.
std::string PictureHtml(const Report& report) {
  if (report.pictures.empty()) return "";
  const Said full = With("mm", fmt::format("{:g}", 1e3 * kMostOff));
  return "<canvas id=\"cut\" role=\"img\"" + Label("picture") +
         "></canvas>\n<div class=\"at\"><label for=\"whose\">" + Say("of") +
         "</label><select id=\"whose\"></select><label><input id=\"plain\" type=\"checkbox\"> " +
         Say("plain") + "</label></div>\n<p class=\"scale\">" + Say("went") + "<i></i>" +
         Say("stays") + "</p>\n<p class=\"quiet\">" + Say("full_colour", {full}) + "</p>\n";
}

nlohmann::ordered_json PicturesOf(const Report& report) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < report.pictures.size(); ++i) {
    const PackedPicture packed = Packed(report.pictures[i]);
    const Vec3 middle = 1e3 * packed.middle;
    json.push_back({{"name", i == 0 ? "the expert" : report.trials[i - 1].name},
                    {"middle_mm", {middle.x(), middle.y(), middle.z()}},
                    {"reach_mm", 1e3 * packed.reach},
                    {"places", packed.places},
                    {"off", packed.off},
                    {"colours", packed.colours},
                    {"corners", packed.corners}});
  }
  return json;
}

/// Returns whose trials they are, and when the first was begun; each may be missing.
std::vector<std::string> WhoAndWhen(const Report& report) {
  std::vector<std::string> all;
  if (!report.person.empty()) all.push_back(report.person);
  if (report.begun_ns > 0) {
    all.push_back(
        fmt::format("{:%F %H:%M} UTC", fmt::gmtime(std::time_t(report.begun_ns / 1'000'000'000))));
  }
  return all;
}

/// Returns the name under which a browser saves or prints the page, as score_words.js does.
std::string TitleOf(const Report& report) {
  std::string title = report.criteria ? report.criteria->title : InEnglish("untitled");
  for (const std::string& one : WhoAndWhen(report)) title += " – " + one;
  return title;
}

std::string HeadHtml(const Report& report) {
  std::string html =
      "<nav class=\"languages\"></nav>\n<h1>" +
      (report.criteria ? Say(report.criteria->titles, report.criteria->title) : Say("untitled")) +
      "</h1>\n<p>";
  for (const std::string& one : WhoAndWhen(report)) {
    html += "<span class=\"who\">" + Escaped(one) + "</span> ";
  }
  const std::string names = Joined(report.trials, &Trial::name);
  return html + "</p>\n<p class=\"quiet\">" +
         Say("beside", {With("trials", names), With("expert", report.expert)}) + "</p>\n";
}

std::string SpaceHtml() {
  return "<h2>" + Say("space") + "</h2>\n<canvas id=\"space\" role=\"img\"" +
         Label("space_picture") + "></canvas>\n<div class=\"at\"><label for=\"time\">" +
         Say("time_of_expert") +
         "</label><input id=\"time\" type=\"range\" min=\"0\" max=\"1\" value=\"0\"><output "
         "id=\"clock\" for=\"time\"></output></div>\n<ul id=\"now\" class=\"now\"></ul>\n<p "
         "class=\"quiet\">" +
         Say("space_how") + "</p>\n<h2>" + Say("over_time") + "</h2>\n";
}

std::string CutHtml(const Report& report) {
  if (report.expert_cut.empty()) return "";
  std::string html = "<h2>" + Say("cut") + "</h2>\n<div class=\"wide\"><table>\n" +
                     HeadRow(report, {"tissue", "there_was", "expert"});
  const auto cell = [](const TissueCut& tissue) {
    const double share = tissue.before_mm3 > 0.0 ? tissue.removed_mm3() / tissue.before_mm3 : 0.0;
    return fmt::format("{:.2f} mm³<br><span class=\"points\">{:.1f} %</span>", tissue.removed_mm3(),
                       100.0 * share);
  };
  for (const TissueCut& tissue : report.expert_cut) {
    html += "<tr>" + Cell(TissueHtml(tissue.name)) +
            Cell(fmt::format("{:.2f} mm³", tissue.before_mm3)) + Cell(cell(tissue));
    std::vector<double> removed;
    for (const auto& cut : report.cuts) {
      const TissueCut& of_trial = TissueOf(cut, tissue.name);
      html += Cell(cell(of_trial));
      removed.push_back(of_trial.removed_mm3());
    }
    html += AverageCell(report, AverageOf(removed), 2) + "</tr>\n";
  }
  const auto beside = [&](const char* what, double TargetDifference::*volume) {
    html += "<tr>" + Cell(Say(what)) + Cell("") + Cell("");
    const auto values = Each(report, [&](std::size_t i) { return report.differences[i].*volume; });
    for (const double value : values) html += Cell(fmt::format("{:.2f} mm³", value));
    html += AverageCell(report, AverageOf(values), 2) + "</tr>\n";
  };
  if (!report.differences.empty()) {
    beside("missed", &TargetDifference::missed_mm3);
    beside("excess", &TargetDifference::excess_mm3);
  }
  return html + "</table></div>\n" + PictureHtml(report);
}

bool HaveEqualSolids(const SolidsCut& a, const SolidsCut& b) {
  return std::ranges::equal(a.after, b.after, [](const CutField& one, const CutField& other) {
    const Lattice &l = one.field().lattice(), &m = other.field().lattice();
    return l.blocks == m.blocks && l.origin == m.origin && l.spacing == m.spacing;
  });
}

/// The expert's performance, with what all trials need of it.
struct Expert {
  Performance done{};
  std::vector<SolidSurface> surfaces{};
  WholeVolumes whole{};
};

std::vector<LocalText> WhyIncomplete(const HandPath& trial) {
  std::vector<LocalText> why;
  if (trial.cut_off) why.push_back(InAll("cut_off"));
  if (trial.unanswered_share > kMostUnanswered) {
    why.push_back(InAll("unanswered", {With("percent", 100.0 * trial.unanswered_share)}));
  }
  return why;
}

/// Adds a trial: its cuts compared with the expert's, if he has cut, and its grade, if there
/// are criteria.
/// @param cut  none: taken from the recording, if needed.
void AddTrial(Expert& expert, const HandPath& trial, std::optional<SolidsCut> cut,
              const std::string& file, const std::string& name, Report& report) {
  const Performance& done = expert.done;
  if (trial.scene != done.path.scene) {
    throw Error(file + ": was recorded in scene '" + trial.scene + "', the expert's in '" +
                done.path.scene + "'; give recordings of one scene");
  }
  report.trials.push_back({name, ScorePath(done.path, trial), WhyIncomplete(trial)});
  report.sessions.push_back(trial.sessions);
  const std::optional<SolidsCut>& target = done.cut;
  std::optional<CutShape> shape;
  if (target) {
    if (trial.sessions > 1) {
      throw Error(fmt::format(
          "{}: holds {} sessions; choose one: what a tool cut in several cannot be computed", file,
          trial.sessions));
    }
    if (!cut) cut = CutIn(file, trial);
    report.cuts.push_back(TissuesOf(*cut, std::nullopt, &expert.whole));
    if (!HaveEqualSolids(*cut, *target) ||
        !std::ranges::equal(report.cuts.back(), report.expert_cut, {}, &TissueCut::name,
                            &TissueCut::name)) {
      throw Error(file + ": its scene '" + trial.scene +
                  "' has other tissues than the expert's; give recordings of one scene");
    }
    const std::vector<SolidSurface> surfaces = SurfacesOf(*cut);
    if (!report.expert_cut.empty()) {
      report.differences.push_back(DifferenceTo(*target, *cut, "", std::nullopt));
      report.pictures.push_back(PictureOf(*cut, surfaces, *target, expert.surfaces));
    }
    if (report.criteria && AsksForCuts(*report.criteria)) {
      shape.emplace(*cut, surfaces, report.cuts.back());
    }
  }
  if (!report.criteria) return;
  report.grades.push_back(GradeTrial(
      *report.criteria, report.trials.back().score, trial, [&](const Criterion& criterion) {
        return MeasureCut(criterion, *target, *cut, *shape, report.criteria->file);
      }));
}

void AddExpert(Expert& expert, Report& report) {
  const std::optional<SolidsCut>& cut = expert.done.cut;
  if (!cut) return;
  report.expert_cut = TissuesOf(*cut, std::nullopt, &expert.whole);
  if (report.expert_cut.empty()) return;
  expert.surfaces = SurfacesOf(*cut);
  report.pictures.push_back(PictureOf(*cut, expert.surfaces, *cut, expert.surfaces));
}

HandPath PathIn(const std::string& file, const SessionChoice& choice) {
  return TrialIn(ReadHandPath({file}, choice), file);
}

/// @param first  a trial, for scene and tool.   @param played  that scene, if loaded.
void SetExpert(const ScoreOptions& options, const HandPath& first,
               const std::optional<PlayedScene>& played, Expert& expert, Report& report) {
  if (options.expert.ends_with(kScriptEnding)) {
    expert.done = Perform(played ? *played : SceneIn(options.trials.front(), first.scene),
                          first.tool_name, PoseScript::Load(options.expert));
    expert.done.path = TrialIn(expert.done.path, options.expert);
  } else {
    expert.done.path = PathIn(options.expert, {options.expert_station, "--expert-station"});
    if (expert.done.path.cuts || (report.criteria && AsksForCuts(*report.criteria))) {
      expert.done.cut = CutIn(options.expert, expert.done.path);
    }
  }
  AddExpert(expert, report);
}

nlohmann::ordered_json JsonOf(const std::vector<TissueCut>& cut) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const TissueCut& tissue : cut) {
    json.push_back({{"tissue", tissue.name},
                    {"before_mm3", tissue.before_mm3},
                    {"removed_mm3", tissue.removed_mm3()}});
  }
  return json;
}

nlohmann::ordered_json TrackJson(const std::string& name, const std::vector<Vec3>& p_m,
                                 const std::vector<double>& force_N,
                                 const std::vector<double>* distance_mm, std::size_t stride) {
  const auto rounded = [](double value, double step) { return std::round(value / step) * step; };
  nlohmann::ordered_json track{{"name", name}, {"p", nlohmann::ordered_json::array()}};
  for (std::size_t i = 0; i < p_m.size(); i += stride) {
    const Vec3 p = 1e3 * p_m[i];
    track["p"].push_back({rounded(p.x(), 1e-3), rounded(p.y(), 1e-3), rounded(p.z(), 1e-3)});
    track["f"].push_back(rounded(force_N[i], 1e-4));
    if (distance_mm) track["d"].push_back(rounded((*distance_mm)[i], 1e-3));
  }
  return track;
}

nlohmann::ordered_json TracksOf(const Report& report) {
  const Score& first = report.trials.front().score;
  const std::size_t stride = first.time_s.size() / kMostShown + 1;
  nlohmann::ordered_json json{{"time", nlohmann::ordered_json::array()}};
  for (std::size_t i = 0; i < first.time_s.size(); i += stride) {
    json["time"].push_back(first.time_s[i]);
  }
  json["tracks"].push_back(
      TrackJson("expert", first.expert_m, first.expert_force_N, nullptr, stride));
  for (const Trial& trial : report.trials) {
    json["tracks"].push_back(TrackJson(trial.name, trial.score.trainee_m,
                                       trial.score.trainee_force_N, &trial.score.distance_mm,
                                       stride));
  }
  return json;
}

nlohmann::ordered_json JsonOf(const Score& score) {
  nlohmann::ordered_json json;
  for (const auto& [name, value] : NumbersOf(score)) json[name] = value;
  return json;
}

nlohmann::ordered_json JsonOf(const Report& report) {
  nlohmann::ordered_json json;
  if (report.trials.size() == 1) json = JsonOf(report.trials.front().score);
  json["expert"] = report.expert;
  if (!report.expert_cut.empty()) json["expert_cut"] = JsonOf(report.expert_cut);
  json["trials"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < report.trials.size(); ++i) {
    nlohmann::ordered_json trial = JsonOf(report.trials[i].score);
    trial["trial"] = report.trials[i].name;
    if (!report.trials[i].incomplete.empty()) trial["incomplete"] = WhyIncomplete(report.trials[i]);
    if (!report.expert_cut.empty()) trial["cut"] = JsonOf(report.cuts[i]);
    if (i < report.differences.size()) {
      trial["missed_mm3"] = report.differences[i].missed_mm3;
      trial["excess_mm3"] = report.differences[i].excess_mm3;
    }
    if (i < report.sessions.size()) trial["sessions"] = report.sessions[i];
    if (report.criteria && !report.grades[i]) trial["points"] = nullptr;
    if (report.criteria && report.grades[i]) {
      const Grade& grade = *report.grades[i];
      trial["points"] = grade.points;
      trial["done_share"] = grade.done;
      trial["harmless_share"] = grade.harmless;
      for (std::size_t c = 0; c < grade.marks.size(); ++c) {
        const Grade::Mark& mark = grade.marks[c];
        trial["marks"].push_back(
            {{"criterion", report.criteria->criteria[c].name},
             {"value", mark.value ? nlohmann::ordered_json(*mark.value) : nullptr},
             {"points", mark.points},
             {"ungated", mark.ungated}});
      }
      for (std::size_t s = 0; s < grade.depths.size(); ++s) {
        nlohmann::ordered_json site{{"site", report.criteria->sites[s].name}};
        if (grade.depths[s]) site["depth_mm"] = 1e3 * *grade.depths[s];
        trial["sites"].push_back(site);
      }
    }
    json["trials"].push_back(trial);
  }
  if (report.criteria) {
    json["points"] = nullptr;
    if (const auto points = PointsOf(report)) {
      json["points"] = {{"mean", points->mean}, {"deviation", points->deviation}};
    }
    json["passed"] = Passed(report);
  }
  return json;
}

std::string JsonText(const Report& report) {
  return JsonOf(report).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace

bool Passed(const Report& report) {
  const auto points = PointsOf(report);
  return points && points->mean >= report.criteria->pass &&
         std::ranges::all_of(report.trials, &std::vector<LocalText>::empty, &Trial::incomplete);
}

Average AverageOf(const std::vector<double>& values) {
  Average average;
  const auto n = static_cast<double>(values.size());
  average.mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  if (values.size() < 2) return average;
  double squares = 0.0;
  for (const double value : values) squares += (value - average.mean) * (value - average.mean);
  average.deviation = std::sqrt(squares / (n - 1.0));
  return average;
}

Report MakeReport(const ScoreOptions& options, StopSignal* stop) {
  Report report;
  report.expert = NameOf(options.expert, options.expert_station);
  if (!options.criteria.empty()) report.criteria = LoadCriteria(options.criteria);
  const auto station = [&](std::size_t i) {
    return options.stations.empty()       ? ""
           : options.stations.size() == 1 ? options.stations.front()
                                          : options.stations[i];
  };
  Expert expert;
  std::optional<SolidsCut> cut;
  if (stop != nullptr) {
    const std::string& file = options.trials.front();
    if (const auto begun = BegunIn(file, station(0), *stop)) {
      SetExpert(options, begun->session, begun->played, expert, report);
      cut = SweptIn(file, begun->session, begun->played, stop);
    }
  }
  std::vector<HandPath> trials;
  for (std::size_t i = 0; i < options.trials.size(); ++i) {
    const SessionChoice choice{.wanted = station(i), .joins = options.join};
    trials.push_back(PathIn(options.trials[i], choice));
  }
  if (expert.done.path.size() == 0) {
    SetExpert(options, trials.front(), std::nullopt, expert, report);
  }
  report.person = options.person;
  report.begun_ns = trials.front().begun_ns;
  for (std::size_t i = 0; i < trials.size(); ++i) {
    AddTrial(expert, trials[i], std::exchange(cut, std::nullopt), options.trials[i],
             NameOf(options.trials[i], station(i)), report);
  }
  return report;
}

Report Rehearse(const Exercise& exercise, const OtherHands& others) {
  Report report;
  report.expert = NameOf(exercise.expert, "");
  report.criteria = exercise.criteria;
  const auto scene = std::make_shared<const Scene>(LoadScene(exercise.scene));
  const PlayedScene played{scene, MakeObjects(*scene)};
  Expert expert{Perform(played, exercise.tool, PoseScript::Load(exercise.expert))};
  const std::vector<PoseScript> hands =
      others ? others(expert.done.path) : std::vector<PoseScript>();
  expert.done.path = TrialIn(expert.done.path, exercise.expert);
  AddExpert(expert, report);
  AddTrial(expert, expert.done.path, expert.done.cut, exercise.expert, report.expert, report);
  for (const PoseScript& hand : hands) {
    Performance trial = Perform(played, exercise.tool, hand);
    AddTrial(expert, TrialIn(trial.path, exercise.expert), std::move(trial.cut), exercise.expert,
             fmt::format("{} {}", report.expert, report.trials.size() + 1), report);
  }
  return report;
}

std::string ToText(const Report& report) {
  const std::size_t trials = report.trials.size();
  std::string text =
      (trials == 1 ? report.trials.front().name : fmt::format("average of {} trials", trials)) +
      "; the expert's\n";
  for (const Figure& figure : kFigures) {
    const auto values =
        Each(report, [&](std::size_t i) { return report.trials[i].score.*figure.trainee; });
    text += fmt::format("  {:<34} {:<18}", figure.name,
                        ToText(AverageOf(values), figure.digits, figure.unit));
    if (figure.expert) {
      text += fmt::format(" {:.{}f}", report.trials.front().score.*figure.expert, figure.digits);
    }
    text += "\n";
  }
  for (const TissueCut& tissue : report.expert_cut) {
    const auto removed = Each(
        report, [&](std::size_t i) { return TissueOf(report.cuts[i], tissue.name).removed_mm3(); });
    text +=
        fmt::format("  {:<34} {:<18} {:.2f} of {:.2f} mm³\n", tissue.name + " removed",
                    ToText(AverageOf(removed), 2, "mm³"), tissue.removed_mm3(), tissue.before_mm3);
  }
  for (const Trial& trial : report.trials) {
    if (trial.incomplete.empty()) continue;
    text += trial.name + " is not complete, and does not pass: " + WhyIncomplete(trial) + "\n";
  }
  if (report.criteria) {
    const auto points = PointsOf(report);
    text += Printable(report.criteria->title) + ": " +
            (points ? fmt::format("{} of 100 points, {}\n", ToText(*points, 0),
                                  Passed(report) ? "passed" : "not yet")
                    : fmt::format("{}: no points\n", kUntouched));
    for (const std::string& taken : TakenTexts(report, &InEnglish)) {
      text += "  " + Printable(taken) + "\n";
    }
  }
  if (trials == 1) text += std::string(kOneTrial) + "\n";
  return text;
}

void WriteJson(const Report& report, const std::string& file) {
  WriteOutput("--json", file, JsonText(report));
}

std::string ToHtml(const Report& report) {
  const std::vector<Trial>& trials = report.trials;
  const std::string html =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<title>" +
      Escaped(TitleOf(report)) + "</title>\n<style>" + kScorePagePalette + kScorePageCss +
      "</style>\n</head>\n<body>\n" + HeadHtml(report) + VerdictHtml(report);
  std::string body;
  for (const Trial& trial : trials) {
    if (trial.incomplete.empty()) continue;
    body += "<p class=\"poor\">" +
            Say("incomplete", {With("trial", trial.name), Said{"why", trial.incomplete}}) +
            "</p>\n";
  }
  if (trials.size() == 1) body += "<p class=\"quiet\">" + Say("one_trial") + "</p>\n";
  if (report.criteria) body += MarksHtml(report) + SitesHtml(report);
  body += CutHtml(report) + SpaceHtml() + ToSvg(PlotsOf(trials)) + "\n" + FiguresHtml(report);
  if (report.criteria) {
    const std::string file = std::filesystem::path(report.criteria->file).filename().string();
    body += "<p class=\"quiet\">" + Say("graded_by", {With("file", file)}) + "</p>\n";
  }
  body += "<script>\nconst words = " + ScoreCatalogues() + ";\n" + kScoreWordsJs +
          "</script>\n<script>\nconst score = " + Embedded(TracksOf(report)) + ";\n" +
          kScorePageJs + "</script>\n";
  if (!report.pictures.empty()) {
    body += "<script>\nconst pictures = " + Embedded(PicturesOf(report)) + ";\n" + kScoreCutJs +
            "</script>\n";
  }
  return html + body + "</body>\n</html>\n";
}

void WriteReport(const Report& report, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw Error(folder + ": " + error.message() + "; give another --out");
  const auto write = [&](const char* name, const std::string& text) {
    WriteOutput("--out", folder + name, text, Links::kReplace);  // of a course, say
  };
  write("/score.html", ToHtml(report));
  write("/score.svg", ToSvg(PlotsOf(report.trials)));
  write("/score.json", JsonText(report));
}

void WriteNewCriteria(const std::string& file, const std::string& scene) {
  if (std::filesystem::exists(file)) {
    throw Error(file + ": exists already; give another name, so that no work is lost");
  }
  if (scene.empty()) return WriteOutput("criteria", file, kCriteriaToBeginWith);
  const std::string source = CriteriaFileBeside(scene);
  if (!std::filesystem::exists(source)) {
    throw Error("--scene " + scene + ": has no criteria, " + source +
                "; omit it to get criteria for probing");
  }
  WriteOutput("criteria", file, ReadWholeFile(source, JsonNode::kMostBytes));
}

}  // namespace palpate
