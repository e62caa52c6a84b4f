// palpate-bench tree: how well sphere trees approximate a mesh, or those of a scene, level by
// level, and the resulting error of the force on the scene's own path.
#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "common/files/output.h"
#include "scenes/mesh/mesh_import.h"
#include "scenes/mesh/mesh_mend.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/units.h"
#include "scenes/progress_line.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "scenes/tree/tree_error.h"
#include "scenes/tree/tree_error_table.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/pose_source.h"
#include "tests/benchmarks/scene_run.h"

namespace palpate::bench {
namespace {

struct Options {
  std::string scene = "bunny-bunny", mesh, models, json, csv, out;
  std::vector<std::string> modes;  ///< empty: all modes for a scene, the first for a mesh
  std::optional<std::size_t> leaves;
  std::size_t samples = 100003;
  std::optional<int> steps;
  bool no_force = false;
  std::string unit = "m";  ///< of the mesh
};

struct ModeResult {
  std::string mode;
  double build_s;
  std::vector<BodyTreeError> bodies;
};

using Clock = std::chrono::steady_clock;

SphereTree Build(const TriangleMesh& mesh, std::size_t leaves, TreeMode mode,
                 const std::string& name) {
  ProgressText text;
  const auto tell = [&](std::string_view stage, double done) {
    Progress(text(fmt::format("{}: {}", name, stage), done));
  };
  return BuildSphereTree(mesh, leaves, tell, mode);
}

/// Builds each body again; bodies with the same mesh and count share a tree.
double Rebuild(Scene& scene, TreeMode mode, std::optional<std::size_t> leaves) {
  double seconds = 0.0;
  std::vector<const Body*> built;
  for (auto* bodies : {&scene.tools, &scene.objects}) {
    for (Body& body : *bodies) {
      if (body.tree.leaves() == 1) continue;  // a ball needs no tree
      const std::size_t count = leaves.value_or(body.tree.leaves());
      const auto same = std::find_if(built.begin(), built.end(), [&](const Body* other) {
        return other->tree.leaves() == count && other->mesh.vertices == body.mesh.vertices &&
               other->mesh.triangles == body.mesh.triangles;
      });
      if (same != built.end()) {
        body.tree = (*same)->tree;
        continue;
      }
      const auto began = Clock::now();
      body.tree = Build(body.mesh, count, mode, body.name);
      seconds += std::chrono::duration<double>(Clock::now() - began).count();
      built.push_back(&body);
    }
  }
  Progress("");
  return seconds;
}

std::vector<Wrench> WrenchesOf(const Scene& scene, ContactModel contact,
                               const std::vector<Pose>& poses) {
  Scene felt = scene;
  felt.features = {.contact = contact};
  SceneRun run(std::move(felt), poses);
  std::vector<StepReport> reports;
  run.Time(&reports);
  std::vector<Wrench> wrenches;
  for (const StepReport& report : reports) wrenches.push_back(report.wrench);
  return wrenches;
}

void MeasureBodies(const Scene& scene, std::size_t samples, ModeResult& result) {
  std::vector<const Body*> known;
  for (const auto* bodies : {&scene.tools, &scene.objects}) {
    for (const Body& body : *bodies) {
      const bool again = std::any_of(known.begin(), known.end(), [&](const Body* other) {
        return other->mesh.vertices == body.mesh.vertices && other->tree.leaf_x == body.tree.leaf_x;
      });
      if (again || body.tree.leaves() == 1) continue;
      Progress(fmt::format("measuring {} ...", body.name));
      result.bodies.push_back({body.name, MeasureLevels(body.mesh, body.tree, samples)});
      known.push_back(&body);
    }
  }
  Progress("");
}

/// The measured trees, as text, CSV and JSON.
struct Report {
  std::string text, csv;
  Json json;

  /// @param one_body  whether there is only one.   @returns the JSON of the mode.
  Json Add(const std::string& of, const ModeResult& result, bool one_body) {
    text += fmt::format("{}, {}: built in {:.2f} s\n", of, result.mode, result.build_s);
    Json entry{{"mode", result.mode}, {"build_s", result.build_s}};
    for (const BodyTreeError& body : result.bodies) {
      text += ToText(body);
      csv += ToCsv(body, result.mode, csv.empty());
      Json measured = Json::parse(ToJsonText(body));
      if (one_body) {
        entry["levels"] = measured["levels"];
      } else {
        entry["bodies"].push_back(measured);
      }
    }
    return entry;
  }

  void Write(const Options& options) const {
    std::fputs(text.c_str(), stderr);
    std::fprintf(stderr, "  %s\n", std::string(kWhatLevelsAre).c_str());
    if (!options.json.empty()) WriteJson(options.json, json);
    if (!options.csv.empty()) WriteOutput("--csv", options.csv, csv);
  }
};

/// Loads it in metres and its file's frame, so that the output of --out can be overlaid on it.
TriangleMesh LoadMesh(const Options& options) {
  TriangleMesh mesh = ImportMesh(options.mesh);
  const MeshReport report = InspectMesh(mesh);
  if (!report.refusal.empty()) throw Error(options.mesh + ": " + report.refusal);
  for (const std::string& remark : MendMesh(mesh)) {
    std::fprintf(stderr, "note: %s\n", remark.c_str());
  }
  PlaceMesh(
      {.metres_per_unit = MetresPerUnit(options.unit), .origin = MeshPlacement::Origin::kFile},
      mesh);
  return mesh;
}

/// "x y z r" of each leaf [m].
std::string LeavesAsText(const SphereTree& tree) {
  std::string text;
  for (std::size_t i = 0; i < tree.leaves(); ++i) {
    text += fmt::format("{:.17g} {:.17g} {:.17g} {:.17g}\n", tree.leaf_x[i], tree.leaf_y[i],
                        tree.leaf_z[i], tree.leaf_radius[i]);
  }
  return text;
}

void RunMesh(const Options& options, std::vector<std::string> modes) {
  if (!options.leaves) throw UsageError("tree: --mesh needs --spheres N");
  if (modes.empty()) modes = {std::string(kTreeModes[0])};
  if (modes.size() > 1 && !options.out.empty()) {
    throw UsageError("tree: --out takes the leaves of one tree; give one --mode");
  }
  const TriangleMesh mesh = LoadMesh(options);
  Report report;
  report.json = {{"mesh", options.mesh},
                 {"metres_per_unit", MetresPerUnit(options.unit)},
                 {"samples", options.samples},
                 {"machine", ToJson(ThisMachine())}};
  for (const std::string& name : modes) {
    const auto began = Clock::now();
    const SphereTree tree = Build(mesh, *options.leaves, TreeModeNamed(name), options.mesh);
    ModeResult result{name, std::chrono::duration<double>(Clock::now() - began).count(), {}};
    Progress("measuring ...");
    result.bodies.push_back({options.mesh, MeasureLevels(mesh, tree, options.samples)});
    Progress("");
    Json entry = report.Add(options.mesh, result, true);
    if (modes.size() == 1) {
      report.json.update(entry);
    } else {
      report.json["modes"].push_back(std::move(entry));
    }
    if (!options.out.empty()) WriteOutput("--out", options.out, LeavesAsText(tree));
  }
  report.Write(options);
}

void RunScene(const Options& options, std::vector<std::string> modes) {
  if (!options.out.empty()) throw UsageError("tree: --out is for the leaves of a --mesh");
  if (modes.empty()) modes = {kTreeModes.begin(), kTreeModes.end()};
  const Scene loaded = LoadForBench(options.scene, options.models);
  std::vector<Pose> poses;
  std::vector<Wrench> truth;
  if (!options.no_force) {
    poses = ScriptPoses(options.scene, options.steps);
    Progress("the meshes themselves ...");
    truth = WrenchesOf(loaded, ContactModel::kSurface, poses);
  }
  Report report;
  report.json = {{"scene", options.scene},
                 {"samples", options.samples},
                 {"steps", poses.size()},
                 {"machine", ToJson(ThisMachine())}};
  for (const std::string& name : modes) {
    Scene scene = loaded;
    ModeResult result{name, Rebuild(scene, TreeModeNamed(name), options.leaves), {}};
    MeasureBodies(scene, options.samples, result);
    Json entry = report.Add(options.scene, result, false);
    if (!options.no_force) {
      Progress("forces ...");
      const ForceDifference off =
          DifferenceOf(WrenchesOf(scene, ContactModel::kSpheres, poses), truth);
      Progress("");
      report.text += fmt::format(
          "  force off that of the meshes' surface, of its mean: mean {:.4f}, max {:.3f}; torque "
          "mean {:.4f}; {} steps\n",
          off.force, off.force_max, off.torque, poses.size());
      entry["against_surface"] = {
          {"force", off.force}, {"force_max", off.force_max}, {"torque", off.torque}};
    }
    report.json["modes"].push_back(std::move(entry));
  }
  report.Write(options);
}

void Run(const Options& options) {
  for (const auto& [option, file] :
       {std::pair("--json", options.json), std::pair("--csv", options.csv),
        std::pair("--out", options.out)}) {
    if (!file.empty()) CheckOutput(option, file);
  }
  options.mesh.empty() ? RunScene(options, options.modes) : RunMesh(options, options.modes);
}

}  // namespace

void AddTree(const CommandLine& app) {
  auto options = std::make_shared<Options>();
  const CommandLine command =
      app.AddCommand("tree",
                     "distance of sphere trees from their meshes, for every level and mode\n"
                     "For a scene, also compares the force of sphere contact with that of surface\n"
                     "contact on the scene's path.");
  command.Footer("Example: palpate-bench tree --mesh tooth.stl --unit mm --spheres 512 --json -");
  Add(command, "--scene", options->scene, "name in the catalogue, scene file or mesh");
  Add(command, "--mesh", options->mesh, "mesh file, instead of a scene")
      .Excludes(command.Find("--scene"));
  Add(command, "--modes,--mode", options->modes,
      "modes of the trees; default: all, for a mesh " + std::string(kTreeModes[0]))
      .OneOf({kTreeModes.begin(), kTreeModes.end()});
  Add(command, "--leaves,--spheres", options->leaves,
      "leaves of each tree; default: those of the scene")
      .Range(std::size_t{1}, kMaxLeaves);
  Add(command, "--unit", options->unit, "unit of --mesh").OneOf({kUnits.begin(), kUnits.end()});
  Add(command, "--samples", options->samples, "number of sample points on the surface").Positive();
  AddPathSteps(command, options->steps);
  command.AddFlag("--no-force", options->no_force, "measure only the geometry");
  AddModels(command, options->models);
  Add(command, "--out", options->out,
      "write the leaves of --mesh to this file, one line 'x y z r' (m) each; -: standard output");
  AddJson(command, options->json);
  Add(command, "--csv", options->csv, "write one line per level to this file; -: standard output");
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
