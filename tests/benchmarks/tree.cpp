// palpate-bench tree: how well sphere trees approximate a mesh, level by level.
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

namespace palpate::bench {
namespace {

struct TreeOptions {
  std::string mesh, json, out;
  std::vector<std::string> modes{std::string(kTreeModes[0])};
  std::size_t leaves = 0;
  std::size_t samples = 100003;
  std::string unit = "m";  ///< of the mesh
};

SphereTree Build(const TriangleMesh& mesh, std::size_t leaves, TreeMode mode,
                 const std::string& name) {
  ProgressText text;
  const auto tell = [&](std::string_view stage, double done) {
    Progress(text(fmt::format("{}: {}", name, stage), done));
  };
  return BuildSphereTree(mesh, leaves, tell, mode);
}

/// Loads it in metres and its file's frame, so that the output of --out can be overlaid on it.
TriangleMesh LoadMesh(const TreeOptions& options) {
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

void Run(const TreeOptions& options) {
  for (const auto& [option, file] :
       {std::pair("--json", options.json), std::pair("--out", options.out)}) {
    if (!file.empty()) CheckOutput(option, file);
  }
  if (options.modes.size() > 1 && !options.out.empty()) {
    throw UsageError("tree: --out takes the leaves of one tree; give one --mode");
  }
  const TriangleMesh mesh = LoadMesh(options);
  Json json{{"mesh", options.mesh},
            {"metres_per_unit", MetresPerUnit(options.unit)},
            {"samples", options.samples},
            {"machine", ToJson(ThisMachine())}};
  for (const std::string& mode : options.modes) {
    using Clock = std::chrono::steady_clock;
    const auto began = Clock::now();
    const SphereTree tree = Build(mesh, options.leaves, TreeModeNamed(mode), options.mesh);
    const double build_s = std::chrono::duration<double>(Clock::now() - began).count();
    Progress("measuring ...");
    const BodyTreeError error{options.mesh, MeasureLevels(mesh, tree, options.samples)};
    Progress("");
    fmt::print(stderr, "{}, {}: built in {:.2f} s\n{}", options.mesh, mode, build_s, ToText(error));
    const Json entry{
        {"mode", mode}, {"build_s", build_s}, {"levels", Json::parse(ToJsonText(error))["levels"]}};
    if (options.modes.size() == 1) {
      json.update(entry);
    } else {
      json["modes"].push_back(entry);
    }
    if (!options.out.empty()) WriteOutput("--out", options.out, LeavesAsText(tree));
  }
  fmt::print(stderr, "  {}\n", kWhatLevelsAre);
  if (!options.json.empty()) WriteJson(options.json, json);
}

}  // namespace

void AddTree(const CommandLine& app) {
  auto options = std::make_shared<TreeOptions>();
  const CommandLine command =
      app.AddCommand("tree", "distance of sphere trees from their mesh, for every level and mode");
  command.Footer("Example: palpate-bench tree --mesh tooth.stl --unit mm --spheres 512 --json -");
  Add(command, "--mesh", options->mesh, "mesh file").Required();
  Add(command, "--modes,--mode", options->modes, "modes of the trees")
      .OneOf({kTreeModes.begin(), kTreeModes.end()});
  Add(command, "--spheres,--leaves", options->leaves, "leaves of each tree")
      .Range(std::size_t{1}, kMaxLeaves)
      .Required();
  Add(command, "--unit", options->unit, "unit of the mesh").OneOf({kUnits.begin(), kUnits.end()});
  Add(command, "--samples", options->samples, "number of sample points on the surface").Positive();
  Add(command, "--out", options->out,
      "write the leaves to this file, one line 'x y z r' (m) each; -: standard output");
  AddJson(command, options->json);
  command.Run([options] { Run(*options); });
}

}  // namespace palpate::bench
