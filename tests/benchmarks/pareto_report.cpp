#include "tests/benchmarks/pareto_report.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "common/files/output.h"
#include "common/files/project_files.h"
#include "common/text/quoted.h"
#include "tests/benchmarks/peers/peer.h"

namespace palpate::bench {
namespace {

// The difference of force that people just notice, of the force itself (Jones 1989; Pang, Tan &
// Durlach 1991).
constexpr double kJndLow = 0.06, kJndHigh = 0.08;
// Chapter 2.5.1: mean on the cube with 4,096 spheres, greatest on the ellipsoid with 512.
constexpr double kChapterCubeMean = 0.05, kChapterEllipsoidMax = 0.05;
constexpr double kMillisecond_us = 1000.0;
constexpr double kDeepGoal_um = 10.0;

// ---- numbers as people read them

std::string Number(double v) {
  const double a = std::abs(v);
  if (a == 0.0) return "0";
  if (a < 1e-6) return "< 1e-6";
  if (a >= 1e5) return fmt::format("{:.2e}", v);
  if (a >= 100.0) return fmt::format("{:.0f}", v);
  if (a >= 10.0) return fmt::format("{:.1f}", v);
  if (a >= 0.1) return fmt::format("{:.2f}", v);
  if (a >= 1e-4) return fmt::format("{:.2g}", v);
  return fmt::format("{:.0e}", v);
}

std::string Thousands(std::size_t n) {
  std::string digits = std::to_string(n);
  for (int i = static_cast<int>(digits.size()) - 3; i > 0; i -= 3) {
    digits.insert(static_cast<std::size_t>(i), ",");
  }
  return digits;
}

// ---- Markdown

class Markdown {
 public:
  void Heading(int level, const std::string& text) {
    text_ += fmt::format("{} {}\n\n", std::string(static_cast<std::size_t>(level), '#'), text);
  }
  void Paragraph(const std::string& text) { text_ += text + "\n\n"; }
  void List(const std::vector<std::string>& items) {
    for (const std::string& item : items) text_ += "- " + item + "\n";
    if (!items.empty()) text_ += "\n";
  }
  /// `align`: one letter a column, l or r.
  void Table(const std::string& align, const std::vector<std::string>& head,
             const std::vector<std::vector<std::string>>& rows) {
    Row(head);
    std::vector<std::string> rule;
    for (const char a : align) rule.push_back(a == 'r' ? "---:" : "---");
    Row(rule);
    for (const auto& row : rows) Row(row);
    text_ += "\n";
  }
  const std::string& text() const { return text_; }

 private:
  void Row(const std::vector<std::string>& cells) {
    text_ += "|";
    for (const std::string& cell : cells) {
      text_ += " ";
      for (const char c : cell) text_ += c == '|' ? "\\|" : std::string(1, c == '\n' ? ' ' : c);
      text_ += " |";
    }
    text_ += "\n";
  }
  std::string text_;
};

/// Rows of what was measured, and a sentence on what was not: a reason is too long for a cell, and
/// often the same for several.
class Rows {
 public:
  /// @param name  of the row, as the sentence tells it
  void Add(const Measured& m, const std::string& name, std::vector<std::string> cells) {
    if (m.not_available.empty()) {
      rows_.push_back(std::move(cells));
      return;
    }
    for (auto& [reason, names] : refused_) {
      if (reason != m.not_available) continue;
      names += "; " + name;
      return;
    }
    refused_.emplace_back(m.not_available, name);
  }
  void Print(Markdown& md, const std::string& align, const std::vector<std::string>& head) const {
    if (!rows_.empty()) md.Table(align, head, rows_);
    for (const auto& [reason, names] : refused_) {
      md.Paragraph(fmt::format("Not available: {} ({}).", names, reason));
    }
    if (rows_.empty() && refused_.empty()) md.Paragraph("Not measured.");
  }

 private:
  std::vector<std::vector<std::string>> rows_;
  std::vector<std::pair<std::string, std::string>> refused_;
};

std::string ContactName(const std::string& contact) {
  return (contact == "spheres" ? "sphere" : contact) + " contact";
}

// ---- finding what was measured

/// @param triangles  of the object's mesh; 0: as the experiment has it.
const SlideResult* FindSlide(const ParetoResults& r, const std::string& object, std::size_t spheres,
                             const std::string& contact, std::size_t triangles = 0) {
  for (const SlideResult& s : r.slides) {
    if (s.object == object && s.spheres == spheres && s.contact == contact && s.slide &&
        (triangles == 0 || s.triangles == triangles)) {
      return &s;
    }
  }
  return nullptr;
}

const ModelRun* FindRun(const ParetoResults& r, const std::string& scene,
                        const std::string& contact, const std::string& friction) {
  for (const SceneResult& s : r.scenes) {
    if (s.scene != scene) continue;
    for (const ModelRun& run : s.runs) {
      if (run.contact == contact && run.friction == friction && run.path) return &run;
    }
  }
  return nullptr;
}

/// A figure that the chapter reached or the project set itself.
struct Goal {
  std::string what;
  bool chapters;
  double bound;
  std::string unit;
  std::optional<double> here;

  bool held() const { return *here <= bound; }
};

std::vector<Goal> Goals(const ParetoResults& r) {
  const auto slide = [&](const std::string& object, std::size_t spheres, const std::string& contact,
                         double MeanMax::*which, std::size_t triangles = 0) {
    const SlideResult* s = FindSlide(r, object, spheres, contact, triangles);
    return s ? std::optional((*s->slide).*which) : std::nullopt;
  };
  const auto p999 = [&](const std::string& scene, const std::string& contact,
                        const std::string& friction = "off") {
    const ModelRun* run = FindRun(r, scene, contact, friction);
    return run ? std::optional(run->speed.best.p999) : std::nullopt;
  };
  const auto worst = [](std::optional<double>& so_far, double value) {
    so_far = std::max(so_far.value_or(0.0), value);
  };
  std::optional<double> cube_mean, cube_max, deepest;  // with surface contact
  for (const SlideResult& s : r.slides) {
    if (s.object != "cube" || s.contact != "surface" || !s.slide) continue;
    worst(cube_mean, s.slide->mean);
    worst(cube_max, s.slide->max);
  }
  for (const SceneResult& s : r.scenes) {
    if (s.yields) continue;
    for (const ModelRun& run : s.runs) {
      if (run.contact == "surface" && run.path) worst(deepest, run.path->penetration_um.max);
    }
  }
  constexpr bool kChapter = true, kOwn = false;
  return {{"force error, cube of 4,096 spheres, sphere contact: mean", kChapter, kChapterCubeMean,
           "", slide("cube", 4096, "spheres", &MeanMax::mean)},
          {"force error, ellipsoid of 512 spheres, sphere contact: greatest", kChapter,
           kChapterEllipsoidMax, "", slide("ellipsoid", 512, "spheres", &MeanMax::max)},
          {"`bunny-bunny`, sphere contact: step", kChapter, 1500.0, " µs",
           p999("bunny-bunny", "spheres")},
          {"`dragon-buddha`, sphere contact: step", kChapter, 2000.0, " µs",
           p999("dragon-buddha", "spheres")},
          {"`oral-cavity`, sphere contact: step", kChapter, 1000.0, " µs",
           p999("oral-cavity", "spheres")},
          {"`pipes`, sphere contact: step", kChapter, 1000.0, " µs", p999("pipes", "spheres")},
          {"force error, cube, surface contact, worst count of spheres: mean", kOwn, 0.001, "",
           cube_mean},
          {"the same: greatest", kOwn, 0.005, "", cube_max},
          {"force error, ellipsoid of 512 spheres and 5,120 triangles, surface contact: greatest",
           kOwn, 0.01, "", slide("ellipsoid", 512, "surface", &MeanMax::max, kFewTriangles)},
          {"the same, 81,920 triangles", kOwn, 0.002, "",
           slide("ellipsoid", 512, "surface", &MeanMax::max, kManyTriangles)},
          {"penetration of the meshes, surface contact, every scene of rigid objects: deepest",
           kOwn, kDeepGoal_um, " µm", deepest},
          {"`bunny-bunny-22k`, surface contact: step", kOwn, 60.0, " µs",
           p999("bunny-bunny-22k", "surface")},
          {"`oral-cavity`, surface contact, Coulomb friction: step", kOwn, 60.0, " µs",
           p999("oral-cavity", "surface", "coulomb")},
          {"`mould`, surface contact: step", kOwn, 200.0, " µs", p999("mould", "surface")}};
}

// ---- the report's sections

std::string Depth(const Measured& m, double Percentiles::*which) {
  return m.path ? Number(m.path->penetration_um.*which) : "–";
}

void Head(Markdown& md, const ParetoResults& r) {
  md.Heading(1, r.only_peers ? "Palpate beside other libraries" : "Palpate: speed against error");
  md.Paragraph(fmt::format(
      "What one haptic step costs, and how wrong its force and its contact are{}, beside the "
      "libraries that are installed. Written by `{}`.",
      r.only_peers ? "" : ", for every scene, contact model and friction model", r.command));
  if (r.quick) {
    md.Paragraph(
        "**A quick look:** few scenes, the beginning of each path, few repeats. Leave out "
        "`--quick` for figures to quote.");
  }
  if (!r.complete) {
    md.Paragraph(
        "**Not complete:** the run was ended, or is still going on. What is here is whole.");
  }
  md.Heading(2, "Machine");
  md.Table("ll", {"", ""},
           {{"processor", r.machine.cpu},
            {"cores", std::to_string(r.machine.cores)},
            {"SIMD", r.machine.simd},
            {"compiler", r.machine.compiler}});
  md.Paragraph(
      "Times are in µs. *Best* is the least of each step over identical repeats, and then the "
      "percentile over the steps: it is what the step costs, while raw times also tell what else "
      "the machine did.");
}

void SpeedAgainstError(Markdown& md, const ParetoResults&) {
  md.Heading(2, "Speed against error");
  md.Paragraph("![Force error and penetration against the time of a step](pareto.svg)");
  md.Paragraph(fmt::format(
      "Down and to the left is better. A value of 0 lies on the lower edge. People notice a "
      "difference of force of {:.0f} to {:.0f} % (Jones 1989; Pang, Tan & Durlach 1991).",
      100.0 * kJndLow, 100.0 * kJndHigh));
}

void Slides(Markdown& md, const ParetoResults& r) {
  md.Heading(2, "Force error");
  md.Paragraph(
      "The experiment of chapter 2.5.1: a ball of 5 mm radius, commanded 1 mm deep at 1 N/mm, "
      "slides along a cube of 50 mm side and along an ellipsoid of semi-axes 40, 25 and 30 mm. The "
      "error is that of the force (2.36) against the analytic object, as a part of 1 N.");
  Rows rows;
  for (const SlideResult& s : r.slides) {
    const MeanMax error = s.slide.value_or(MeanMax{});
    const std::string spheres = Thousands(s.spheres);
    const std::string chapter = s.contact != "spheres"                        ? "–"
                                : s.object == "cube" && s.spheres == 4096     ? "mean 0.05"
                                : s.object == "ellipsoid" && s.spheres == 512 ? "max 0.05"
                                                                              : "–";
    rows.Add(s,
             fmt::format("{} of {} triangles, {} spheres, {}", s.object, Thousands(s.triangles),
                         spheres, ContactName(s.contact)),
             {s.object, spheres, Thousands(s.triangles), s.contact, Number(error.mean),
              Number(error.max), chapter, Number(s.speed.best.p50), Number(s.speed.best.p999)});
  }
  rows.Print(md, "lrrlrrlrr",
             {"object", "spheres", "triangles", "contact", "mean", "max", "chapter", "best p50",
              "best p99.9"});
}

void Scenes(Markdown& md, const ParetoResults& r) {
  md.Heading(2, "Scenes");
  md.Paragraph(
      "Every scene's own path, friction off; *slowest* is the slowest of all contact and friction "
      "models, which `pareto.csv` has one by one. *Deepest* is the penetration of the meshes at "
      "the reported pose, on every n-th step: the deepest vertex inside a closed mesh, or the "
      "shortest way that takes two triangles apart, whichever is more. With sphere contact the "
      "meshes may meet where the spheres, which lie inside them, do not yet: that is the model's "
      "error. Objects of scenes with ¹ are soft: what the tool pressed in counts as penetration of "
      "the meshes, which are as they were. Where a scene has no friction of its own, its objects "
      "have μ_s 0.8 and μ_d 0.3 where a friction model is named.");
  Rows rows;
  for (const SceneResult& s : r.scenes) {
    const std::string name = "`" + s.scene + "`" + (s.yields ? " ¹" : "");
    std::vector<std::string> cells{name, Thousands(s.triangles), Thousands(s.steps)};
    const ModelRun* slowest = nullptr;
    for (const ModelRun& run : s.runs) {
      if (!run.path) continue;
      if (!slowest || run.speed.best.p999 > slowest->speed.best.p999) slowest = &run;
    }
    for (const char* contact : {"spheres", "surface"}) {
      const ModelRun* run = FindRun(r, s.scene, contact, "off");
      cells.push_back(run ? Number(run->speed.best.p50) : "–");
      cells.push_back(run ? Number(run->speed.best.p999) : "–");
      cells.push_back(run ? Depth(*run, &Percentiles::max) : "–");
    }
    cells.push_back(slowest ? Number(slowest->speed.best.p999) : "–");
    Measured available;
    available.not_available = !s.not_available.empty() ? s.not_available
                              : s.runs.empty()         ? "not measured"
                                                       : "";
    rows.Add(available, name, cells);
    for (const ModelRun& run : s.runs) {
      if (run.not_available.empty()) continue;
      rows.Add(run,
               fmt::format("{}, {}, friction {}", name, ContactName(run.contact), run.friction),
               {});
    }
  }
  rows.Print(md, "lrrrrrrrrr",
             {"scene", "triangles", "steps", "spheres: best p50", "p99.9", "deepest [µm]",
              "surface: best p50", "p99.9", "deepest [µm]", "slowest, p99.9"});
}

void Features(Markdown& md, const ParetoResults& r) {
  md.Heading(2, "What each feature costs");
  if (r.features.empty()) {
    md.Paragraph("Not measured.");
    return;
  }
  md.Paragraph(
      fmt::format("The path of `{}`, the same steps for each line, their repeats taken in turns. "
                  "*Undeclared* is the bare step on objects that have friction and stiffness which "
                  "the scene does not declare: it should cost nothing, a ratio of 1.",
                  r.feature_scene));
  Rows rows;
  for (const FeatureCost& f : r.features) {
    rows.Add(f, f.feature,
             {f.feature, Number(f.speed.best.p50), Number(f.speed.best.p999),
              fmt::format("{:.2f}", f.ratio_p50), fmt::format("{:.2f}", f.ratio_p999)});
  }
  rows.Print(md, "lrrrr", {"feature", "best p50", "best p99.9", "p50 ×", "p99.9 ×"});
}

void Peers(Markdown& md, const ParetoResults& r) {
  md.Heading(2, "Peers");
  md.Paragraph(
      "Each in the same run, on the same meshes and hand poses. A peer moves a body of 0.1 kg that "
      "a spring and damper (1000 N/m, 1 N·m/rad, critically damped, 6 degrees of freedom) tie to "
      "the hand, one step a millisecond, without friction and gravity; its force is the spring's. "
      "A ball is the peer's own exact sphere. Times hold the peer's collision detection and its "
      "step. Where a peer does not do the same again from a new start, its best times are raw "
      "ones, marked *raw*.");
  std::vector<std::string> items;
  for (const PeerKind& kind : PeerKinds()) {
    const bool asked =
        std::find(r.peers_asked.begin(), r.peers_asked.end(), kind.id) != r.peers_asked.end();
    items.push_back(!kind.installed() ? fmt::format("**{}** {}.", kind.name, HowToInstall(kind))
                    : asked ? fmt::format("**{} {}** (`{}`): {}.", kind.name, kind.version,
                                          kind.package, kind.settings)
                            : fmt::format("**{} {}** was not asked for.", kind.name, kind.version));
  }
  md.List(items);
  const auto speed = [](const Measured& m, double Percentiles::*which) {
    return Number(m.speed.best.*which) + (m.speed.repeatable ? "" : " raw");
  };
  if (!r.peer_path.empty()) {
    md.Heading(3, fmt::format("The path of `{}`", r.peer_scene));
    Rows rows;
    for (const PeerRun& run : r.peer_path) {
      rows.Add(run, run.name,
               {run.name, speed(run, &Percentiles::p50), speed(run, &Percentiles::p999),
                Depth(run, &Percentiles::p50), Depth(run, &Percentiles::p99),
                Depth(run, &Percentiles::max), run.path ? Number(run.path->force_rms_N) : "–",
                run.path ? Number(run.path->free_force_N) : "–",
                run.path ? Number(run.path->force_jump_N) : "–"});
    }
    rows.Print(md, "lrrrrrrrr",
               {"", "best p50", "best p99.9", "penetration p50 [µm]", "p99 [µm]", "max [µm]",
                "force, RMS [N]", "force in free space [N]", "greatest jump [N]"});
    md.Paragraph(
        fmt::format("{} steps. *Force in free space* is the mean where the hand's own pose is "
                    "free: force of a mesh that is not there, of a margin, or of inertia; or of a "
                    "tool caught behind the object.",
                    Thousands(r.peer_steps)));
  }
  if (!r.peer_slide.empty()) {
    md.Heading(3, "A slide with a known force");
    Rows rows;
    for (const PeerRun& run : r.peer_slide) {
      const MeanMax error = run.slide.value_or(MeanMax{});
      rows.Add(run, run.object + ", " + run.name,
               {run.object, run.name, speed(run, &Percentiles::p50), speed(run, &Percentiles::p999),
                Number(error.rms()), Number(error.mean), Number(error.max),
                Depth(run, &Percentiles::max)});
    }
    rows.Print(md, "llrrrrrr",
               {"object", "", "best p50", "best p99.9", "force error, RMS", "mean", "max",
                "penetration max [µm]"});
    md.Paragraph(
        "A ball of 5 mm radius, commanded 1 mm deep at 1 N/mm, over a cube of 50 mm and over the "
        "20,480 flat triangles of an ellipsoid, the same for all; errors are those of the force "
        "against the analytic object, as a part of 1 N. The hand begins to slide at once, and a "
        "peer's body lags behind until its damper has caught up: that is its greatest error.");
  }
  if (!r.peer_variants.empty()) {
    md.Paragraph(
        "The table in CSV also has the peers with other masses and sub-steps (*peer variant*), on "
        "the beginning of the same path.");
  }
}

/// With all digits where fewer would not tell it from its bound.
std::string Beside(double bound, double here) {
  return here != bound && Number(here) == Number(bound) ? fmt::format("{}", here) : Number(here);
}

void Missed(Markdown& md, const ParetoResults& r) {
  md.Heading(2, "Where a figure is missed");
  std::vector<std::vector<std::string>> rows;
  for (const Goal& goal : Goals(r)) {
    rows.push_back({goal.what, goal.chapters ? "chapter" : "goal",
                    "≤ " + Number(goal.bound) + goal.unit,
                    goal.here ? Beside(goal.bound, *goal.here) + goal.unit : "–",
                    !goal.here    ? "not measured"
                    : goal.held() ? "held"
                                  : "**missed**"});
  }
  md.Table("lllrl", {"figure", "of", "bound", "here", ""}, rows);
  md.Paragraph("A step's time is its best p99.9; the chapter's are on a 2.2 GHz Core 2.");
  md.Paragraph(
      "Times hold for this machine, and other work on it makes even the best of a few repeats "
      "longer; errors are the same anywhere.");
}

// ---- JSON

Json ToJson(const Measured& m) {
  Json json{{"available", m.not_available.empty()}};
  if (!m.not_available.empty()) {
    json["reason"] = m.not_available;
    return json;
  }
  json["best_step_us"] = ToJson(m.speed.best);
  json["raw_step_us"] = ToJson(m.speed.raw);
  json["repeatable"] = m.speed.repeatable;
  if (m.slide) {
    json["force_error"] = {{"mean", m.slide->mean}, {"rms", m.slide->rms()}, {"max", m.slide->max}};
  }
  if (m.path) {
    json["penetration_um"] = ToJson(m.path->penetration_um);
    json["force_rms_N"] = m.path->force_rms_N;
    json["free_force_N"] = m.path->free_force_N;
    json["jump"] = {{"force_N_max", m.path->force_jump_N}};
  }
  return json;
}

Json ToJson(const ModelRun& run) {
  Json json{{"contact", run.contact}, {"friction", run.friction}};
  json.update(ToJson(static_cast<const Measured&>(run)));
  if (run.sphere_overlap_um) json["sphere_overlap_um"] = *run.sphere_overlap_um;
  return json;
}

Json ToJson(const std::vector<PeerRun>& runs) {
  auto json = Json::array();
  for (const PeerRun& run : runs) {
    Json one{{"id", run.id.empty() ? "palpate" : run.id}, {"name", run.name}};
    if (!run.object.empty()) one["object"] = run.object;
    one.update(ToJson(static_cast<const Measured&>(run)));
    json.push_back(one);
  }
  return json;
}

Json ToJson(const ParetoResults& r) {
  Json json{
      {"command", r.command},
      {"quick", r.quick},
      {"complete", r.complete},
      {"machine", ToJson(r.machine)},
      {"human", {{"force_jnd", std::vector{kJndLow, kJndHigh}}}},
      {"chapter",
       {{"cube_mean_at_4096", kChapterCubeMean}, {"ellipsoid_max_at_512", kChapterEllipsoidMax}}}};
  json["accuracy"] = Json::array();
  for (const SlideResult& s : r.slides) {
    Json one{{"object", s.object}, {"spheres", s.spheres}, {"triangles", s.triangles}};
    one.update(ToJson(static_cast<const ModelRun&>(s)));
    json["accuracy"].push_back(one);
  }
  json["scenes"] = Json::array();
  for (const SceneResult& s : r.scenes) {
    Json one{{"scene", s.scene}};
    if (!s.not_available.empty()) {
      one["not_available"] = s.not_available;
    } else {
      one.update({{"tool_spheres", s.tool_spheres},
                  {"object_spheres", s.object_spheres},
                  {"triangles", s.triangles},
                  {"steps", s.steps},
                  {"yields", s.yields}});
    }
    one["runs"] = Json::array();
    for (const ModelRun& run : s.runs) one["runs"].push_back(ToJson(run));
    json["scenes"].push_back(one);
  }
  json["features"] = {{"scene", r.feature_scene}, {"costs", Json::array()}};
  for (const FeatureCost& f : r.features) {
    Json one{{"feature", f.feature}};
    one.update(ToJson(static_cast<const Measured&>(f)));
    if (f.not_available.empty()) one["ratio"] = {{"p50", f.ratio_p50}, {"p999", f.ratio_p999}};
    json["features"]["costs"].push_back(one);
  }
  auto& peers = json["peers"];
  peers["known"] = Json::array();
  for (const PeerKind& kind : PeerKinds()) {
    peers["known"].push_back({{"id", kind.id},
                              {"name", kind.name},
                              {"package", kind.package},
                              {"installed", kind.installed()},
                              {"version", kind.version},
                              {"settings", kind.settings}});
  }
  peers["scene"] = r.peer_scene;
  peers["steps"] = r.peer_steps;
  peers["path"] = ToJson(r.peer_path);
  peers["slide"] = ToJson(r.peer_slide);
  peers["variants"] = ToJson(r.peer_variants);
  json["goals"] = Json::array();
  for (const Goal& goal : Goals(r)) {
    Json one{
        {"what", goal.what}, {"of", goal.chapters ? "chapter" : "goal"}, {"bound", goal.bound}};
    if (goal.here) {
      one["figure"] = *goal.here;
      one["held"] = goal.held();
    }
    json["goals"].push_back(one);
  }
  return json;
}

// ---- CSV: every run, for spreadsheets and plots.py

std::string ToCsv(const ParetoResults& r) {
  std::string csv =
      "part,name,contact,friction,tool_spheres,spheres,triangles,steps,repeatable,best_p50_us,best_"
      "p999_us,error_mean,error_max,penetration_p50_um,penetration_p99_um,penetration_max_um,"
      "sphere_overlap_um,free_force_N,force_jump_N\n";
  // Nothing of what is 0 because nobody counted it.
  const auto count = [](std::size_t n) { return n == 0 ? "" : std::to_string(n); };
  const auto add = [&](const std::string& part, const std::string& name, const ModelRun& run,
                       std::size_t tool, std::size_t spheres, std::size_t triangles,
                       std::size_t steps) {
    if (!run.not_available.empty()) return;
    csv +=
        fmt::format("{},\"{}\",{},{},{},{},{},{},{},{:.6g},{:.6g},", part, name, run.contact,
                    run.friction, count(tool), count(spheres), count(triangles), count(steps),
                    run.speed.repeatable ? "yes" : "no", run.speed.best.p50, run.speed.best.p999);
    csv += run.slide ? fmt::format("{:.6g},{:.6g},", run.slide->mean, run.slide->max) : ",,";
    const auto depth = [](const Percentiles& um) {
      return fmt::format("{:.6g},{:.6g},{:.6g},", um.p50, um.p99, um.max);
    };
    csv += run.path ? depth(run.path->penetration_um) : ",,,";
    csv += run.sphere_overlap_um ? fmt::format("{:.6g},", *run.sphere_overlap_um) : ",";
    csv += run.path ? fmt::format("{:.6g},{:.6g}\n", run.path->free_force_N, run.path->force_jump_N)
                    : ",\n";
  };
  for (const SlideResult& s : r.slides) {
    add("slide", s.object, s, 0, s.spheres, s.triangles, 0);
  }
  for (const SceneResult& s : r.scenes) {
    for (const ModelRun& run : s.runs) {
      add("scene", s.scene, run, s.tool_spheres, s.object_spheres, s.triangles, s.steps);
    }
  }
  for (const auto& [part, runs] :
       {std::pair("peer path", &r.peer_path), std::pair("peer slide", &r.peer_slide),
        std::pair("peer variant", &r.peer_variants)}) {
    for (const PeerRun& run : *runs) {
      add(run.object == "ellipsoid" ? "peer slide on ellipsoid" : part, run.name, {run}, 0, 0, 0,
          0);
    }
  }
  return csv;
}

std::string NameOf(const ParetoResults& results) {
  return results.only_peers ? "peers" : "pareto";
}

}  // namespace

void WritePareto(const std::string& folder, const ParetoResults& results) {
  std::error_code ignored;
  std::filesystem::create_directories(folder, ignored);
  const auto file = [&](const std::string& name) {
    return (std::filesystem::path(folder) / name).string();
  };
  const std::string name = NameOf(results);
  WriteJson(file(name + ".json"), ToJson(results));
  WriteOutput("--out", file(name + ".csv"), ToCsv(results));
  Markdown md;
  Head(md, results);
  if (results.only_peers) {
    md.Paragraph("![Penetration and force error against the time of a step](peers.svg)");
    Peers(md, results);
  } else {
    for (const auto section : {SpeedAgainstError, Slides, Scenes, Features, Peers, Missed}) {
      section(md, results);
    }
  }
  WriteOutput("--out", file("report.md"), md.text());
}

bool DrawPareto(const std::string& folder, const ParetoResults& results) {
  const std::string command = ShellWord(PlaceOf(ProjectFile::kPlots)) + " " +
                              ShellWord(folder + "/" + NameOf(results) + ".csv");
  return std::system(command.c_str()) == 0;
}

}  // namespace palpate::bench
