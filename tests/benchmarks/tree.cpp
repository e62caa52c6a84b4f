// palpate-bench tree: how well sphere trees stand for the meshes of a scene, level by level, and
// what that is worth in the force on the scene's own path.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <optional>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"
#include "scenes/catalogue.h"
#include "scenes/sphere_tree_builder.h"
#include "scenes/tree_error.h"
#include "scenes/tree_error_table.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/pose_source.h"
#include "tests/benchmarks/scene_run.h"
#include "tests/benchmarks/tree_file_option.h"

namespace palpate::bench {
namespace {

struct Options {
  std::string scene = "bunny-bunny", models, json, csv;
  std::vector<std::string> modes{kTreeModes.begin(), kTreeModes.end()};
  std::optional<std::size_t> leaves;
  std::size_t samples = 100003;
  std::optional<int> steps;
  bool no_force = false;
  TreeSource file;  ///< beside the trees that are built; none where it names no file
};

struct ModeResult {
  std::string mode;
  double build_s = 0.0;
  std::vector<BodyTreeError> bodies;
  double force = 0.0, force_max = 0.0, torque = 0.0;  ///< off the surface's, of its mean
};

using Clock = std::chrono::steady_clock;

/// Builds each body anew; bodies of one mesh and count share a tree.
double Rebuild(Scene& scene, TreeMode mode, std::optional<std::size_t> leaves) {
  double seconds = 0.0;
  std::vector<const Body*> built;
  for (auto* bodies : {&scene.tools, &scene.objects}) {
    for (Body& body : *bodies) {
      if (body.tree.leaves() == 1) continue;  // a ball is what it is
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
      body.tree = BuildSphereTree(
          body.mesh, count,
          [&](std::string_view stage, double done) {
            Progress(fmt::format("{}: {} {:.0f} % ...", body.name, stage, 100.0 * done));
          },
          mode);
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

void Compare(ModeResult& result, const std::vector<Wrench>& felt,
             const std::vector<Wrench>& truth) {
  double force = 0.0, torque = 0.0, force_apart = 0.0, torque_apart = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    force += truth[i].force.norm();
    torque += truth[i].torque.norm();
    const double apart = (felt[i].force - truth[i].force).norm();
    force_apart += apart;
    result.force_max = std::max(result.force_max, apart);
    torque_apart += (felt[i].torque - truth[i].torque).norm();
  }
  if (force > 0.0) {
    result.force = force_apart / force;
    result.force_max *= static_cast<double>(truth.size()) / force;
  }
  if (torque > 0.0) result.torque = torque_apart / torque;
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
      result.bodies.push_back({body.name, MeasureLevels(body, samples)});
      known.push_back(&body);
    }
  }
  Progress("");
}

void Run(const Options& options) {
  const Scene loaded = LoadForBench(options.scene, options.models);
  std::vector<Pose> poses;
  std::vector<Wrench> truth;
  if (!options.no_force) {
    poses = ScriptPoses(options.scene, options.steps);
    Progress("the meshes themselves ...");
    truth = WrenchesOf(loaded, ContactModel::kSurface, poses);
  }
  nlohmann::ordered_json json{{"scene", options.scene},
                              {"samples", options.samples},
                              {"steps", poses.size()},
                              {"machine", ToJson(ThisMachine())}};
  std::string csv, text;
  std::vector<std::string> names = options.modes;
  if (!options.file.built()) names.push_back(options.file.file);
  for (const std::string& name : names) {
    const bool of_file = name == options.file.file;
    Scene scene = of_file ? LoadForBench(options.scene, options.models, options.file) : loaded;
    ModeResult result;
    result.mode = name;
    if (!of_file) result.build_s = Rebuild(scene, TreeModeNamed(name), options.leaves);
    MeasureBodies(scene, options.samples, result);
    text += of_file
                ? fmt::format("{}, tree of {}\n", options.scene, name)
                : fmt::format("{}, {}: built in {:.2f} s\n", options.scene, name, result.build_s);
    nlohmann::ordered_json entry{{"mode", name}};
    if (!of_file) entry["build_s"] = result.build_s;
    for (const BodyTreeError& body : result.bodies) {
      text += ToText(body);
      csv += ToCsv(body, name, csv.empty());
      entry["bodies"].push_back(nlohmann::ordered_json::parse(ToJsonText(body)));
    }
    if (!options.no_force) {
      Progress("forces ...");
      Compare(result, WrenchesOf(scene, ContactModel::kSpheres, poses), truth);
      Progress("");
      text += fmt::format(
          "  force off that of the meshes' surface, of its mean: mean {:.4f}, max {:.3f}; torque "
          "mean {:.4f}; {} steps\n",
          result.force, result.force_max, result.torque, poses.size());
      entry["against_surface"] = {
          {"force", result.force}, {"force_max", result.force_max}, {"torque", result.torque}};
    }
    json["modes"].push_back(std::move(entry));
  }
  std::fputs(text.c_str(), stderr);
  if (!options.json.empty()) WriteJson(options.json, json);
  if (options.csv.empty()) return;
  std::ofstream out(options.csv);
  out << csv;
  if (!out.flush()) throw Error(options.csv + ": could not be written; check the folder and space");
}

}  // namespace

void AddTree(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("tree",
                         "How far sphere trees are from their meshes, for every level and mode, "
                         "and how far the force\n"
                         "of sphere contact is from surface contact's on the scene's own path.\n"
                         "Example: palpate-bench tree --scene bunny-bunny --csv tree.csv");
  command->add_option("--scene", options->scene, "Catalogue name, scene file or mesh")
      ->capture_default_str();
  command->add_option("--modes", options->modes, "Modes of the trees")
      ->delimiter(',')
      ->check(CLI::IsMember(std::vector<std::string>(kTreeModes.begin(), kTreeModes.end())));
  command->add_option("--leaves", options->leaves, "Leaves of each tree (default: the scene's)")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 20));
  AddTreeFileOptions(*command, "the mesh's", options->file);
  command->add_option("--samples", options->samples, "Points of the surface")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--steps", options->steps, "Steps (default: the whole path)")
      ->check(CLI::PositiveNumber);
  command->add_flag("--no-force", options->no_force, "Measure the geometry alone");
  command->add_option("--models", options->models, "Folder of models that are not packaged");
  command->add_option("--json", options->json, "Write one JSON object to FILE (- is stdout)");
  command->add_option("--csv", options->csv, "Write a line for each level into FILE");
  command->callback([options] { Run(*options); });
}

}  // namespace palpate::bench
