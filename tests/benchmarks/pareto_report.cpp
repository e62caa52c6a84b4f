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

// Just noticeable difference of a force, relative (Jones 1989; Pang, Tan & Durlach 1991).
constexpr double kJndLow = 0.06, kJndHigh = 0.08;
// Chapter 2.5.1: mean on the cube with 4,096 spheres, greatest on the ellipsoid with 512.
constexpr double kChapterCubeMean = 0.05, kChapterEllipsoidMax = 0.05;
constexpr double kDeepGoal_um = 10.0;

// ---- finding what was measured

/// @param triangles  of the object's mesh; 0: the experiment's default.
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
  auto& peers = json["peers"];
  peers["known"] = Json::array();
  for (const PeerKind& kind : r.peers_known) {
    const bool installed = kind.installed();
    peers["known"].push_back({{"id", kind.id},
                              {"name", kind.name},
                              {"package", kind.package},
                              {"installed", installed},
                              {"install", installed ? "" : HowToInstall(kind)},
                              {"asked", std::ranges::count(r.peers_asked, kind.id) > 0},
                              {"version", kind.version},
                              {"settings", kind.settings}});
  }
  peers["scene"] = r.peer_scene;
  peers["steps"] = r.peer_steps;
  peers["path"] = ToJson(r.peer_path);
  peers["slide"] = ToJson(r.peer_slide);
  json["goals"] = Json::array();
  for (const Goal& goal : Goals(r)) {
    Json one{{"what", goal.what},
             {"of", goal.chapters ? "chapter" : "goal"},
             {"bound", goal.bound},
             {"unit", goal.unit}};
    if (goal.here) {
      one["figure"] = *goal.here;
      one["held"] = goal.held();
    }
    json["goals"].push_back(one);
  }
  return json;
}

std::string FileOf(const std::string& folder, const ParetoResults& results) {
  return std::filesystem::path(folder) / (results.only_peers ? "peers.json" : "pareto.json");
}

}  // namespace

void WritePareto(const std::string& folder, const ParetoResults& results) {
  std::error_code ignored;
  std::filesystem::create_directories(folder, ignored);
  WriteJson(FileOf(folder, results), ToJson(results));
}

bool ReportPareto(const std::string& folder, const ParetoResults& results) {
  std::filesystem::path script = PlaceOf(ProjectFile::kPlots);
  script.replace_filename("pareto_report.py");
  const std::string command = ShellWord(script.string()) + " " + ShellWord(FileOf(folder, results));
  return std::system(command.c_str()) == 0;
}

}  // namespace palpate::bench
