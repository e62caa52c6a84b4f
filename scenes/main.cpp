// palpate-scene: compiles meshes to sphere trees and scene bundles, and reports on them.

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/program/command_line.h"
#include "common/program/log.h"
#include "common/text/joined.h"
#include "common/text/quoted.h"
#include "scenes/catalogue.h"
#include "scenes/compiler/body_lines.h"
#include "scenes/compiler/scene_info.h"
#include "scenes/files/mesh_options.h"
#include "scenes/files/mesh_scene.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/files/scene_file.h"
#include "scenes/mesh/hidden_surface.h"
#include "scenes/mesh/mesh_import.h"
#include "scenes/mesh/mesh_mend.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/picture.h"
#include "scenes/progress_line.h"
#include "scenes/scene_verdict.h"
#include "scenes/tree/leaf_count.h"
#include "scenes/tree/tree_error.h"
#include "scenes/tree/tree_mode.h"

namespace palpate {
namespace {

struct Arguments {
  std::string scene;  ///< name, scene file or bundle; for check also a mesh
  std::string output;
  std::string models;
  std::string cache;
  std::string log_level = "info";
  std::optional<int> level;
  std::string mode;  ///< one of kTreeModes; empty: as the scene file says
  std::optional<LeafTolerance> leaves;
  bool rebuild = false;
  bool whole = false;
  MeshSceneOptions mesh;
  int domain = 0;
};

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Scene Load(const Arguments& arguments) {
  ProgressLine progress;
  LoadOptions options;
  options.models_dir = arguments.models;
  options.cache_dir = arguments.cache;
  options.use_cache = !arguments.rebuild;
  options.leaves = arguments.leaves;
  if (!arguments.mode.empty()) options.tree = TreeModeNamed(arguments.mode);
  options.progress = std::ref(progress);
  options.warn = [&](const std::string& text) {
    progress.Clear();
    std::cerr << "warning: " << Printable(text) << '\n';
  };
  options.tell = [&](const std::string& text) {
    progress.Clear();
    std::cerr << Printable(text) << '\n';
  };
  return LoadScene(arguments.scene, options);
}

/// Prints the verdict; throws if the scene or mesh is not usable.
void Conclude(const std::string& what, const Verdict& verdict) {
  std::fputs(ToText(verdict).c_str(), stdout);
  if (!verdict.usable()) throw Error(what + ": is not usable: " + verdict.faults.front());
}

void Build(const Arguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  const Scene scene = Load(arguments);
  const double seconds = SecondsSince(start);
  std::printf("%s: ready in %.2f s\n", scene.name.c_str(), seconds);
  for (const Body& body : scene.tools) std::fputs(BodyLine("tool", body).c_str(), stdout);
  for (const Body& body : scene.objects) std::fputs(BodyLine("object", body).c_str(), stdout);
  std::fputs(MovedLines(scene).c_str(), stdout);
  Conclude(arguments.scene, JudgeScene(scene));
  if (arguments.output.empty()) return;
  const std::vector<std::uint8_t> bytes = PackScene(scene, 0, Remarks::kKeep);
  WriteFileAtomically(arguments.output, bytes);
  std::printf("wrote %s (%.1f MB)\n", arguments.output.c_str(), 1e-6 * double(bytes.size()));
}

void Info(const Arguments& arguments) {
  const Scene scene = Load(arguments);
  std::fputs(SceneInfo(scene).c_str(), stdout);
  Conclude(arguments.scene, JudgeScene(scene));
}

void PrintReport(const MeshReport& r) {
  const auto yes = [](bool b) { return b ? "yes" : "no"; };
  const Vec3 size = r.box_max - r.box_min;
  std::printf("    %zu triangles, %zu vertices, %zu component%s, box %g x %g x %g\n", r.triangles,
              r.vertices, r.components, r.components == 1 ? "" : "s", size.x(), size.y(), size.z());
  std::printf("    closed %s, manifold %s, oriented %s; degenerate %zu, duplicate %zu triangles\n",
              yes(r.closed()), yes(r.manifold()), yes(r.oriented()), r.degenerate_triangles,
              r.duplicate_triangles);
  for (const std::string& remark : r.remarks)
    std::printf("    note: %s\n", Printable(remark).c_str());
}

/// @param allowed  limit of p99 [m]; 0: the spheres are not felt.
void PrintSpread(const char* name, const Distribution& s, double allowed) {
  std::printf("    %s mean %.1f  p99 %.1f  max %.1f um", name, 1e6 * s.mean, 1e6 * s.p99,
              1e6 * s.max);
  allowed > 0.0 ? std::printf("  (p99 should be at most %.0f)\n", 1e6 * allowed)
                : std::printf("  (not felt)\n");
}

Verdict CheckBody(const Scene& scene, const Body& body, bool is_tool) {
  std::fputs(BodyLine(is_tool ? "tool" : "object", body).c_str(), stdout);
  const BodyFindings found = JudgeBody(scene, body, is_tool, MeasureGaps::kAlways);
  PrintReport(found.report);
  const double allowed = found.by_spheres ? AllowedGap(found.report) : 0.0;
  PrintSpread("outside  ", found.coverage.outside, allowed);
  PrintSpread("uncovered", found.coverage.uncovered, allowed);
  if (!found.hidden.empty()) std::printf("    warning: %s\n", Printable(found.hidden).c_str());
  return found.verdict;
}

/// Prints the contents of a mesh file, before it is made into a scene.
void PrintMesh(const std::string& file) {
  std::vector<MeshGroup> groups;
  TriangleMesh mesh = ImportMesh(file, &groups);
  const MeshReport report = InspectMesh(mesh);
  std::printf("%s (lengths in the file's unit)\n", file.c_str());
  PrintReport(report);
  if (!report.refusal.empty()) {
    Verdict verdict;
    verdict.faults.push_back("mesh: " + report.refusal);
    Conclude(file, verdict);
  }
  MendMesh(mesh, &groups);
  const std::string hidden = HiddenRemark(FindHiddenParts(mesh, groups), 1.0, "of the file's unit");
  if (!hidden.empty()) std::printf("    warning: %s\n", Printable(hidden).c_str());
}

void Check(const Arguments& arguments) {
  if (IsMeshFile(arguments.scene)) PrintMesh(arguments.scene);
  const Scene scene = Load(arguments);
  for (const Effect& effect : scene.effects) {
    std::printf("effect %s: %s\n", effect.file.c_str(),
                effect.of->passive != 0 ? "passive" : "active, at an arm 1 N at most");
  }
  Verdict verdict = JudgeEffects(scene);
  for (const auto* bodies : {&scene.tools, &scene.objects}) {
    for (const Body& body : *bodies) verdict.Add(CheckBody(scene, body, bodies == &scene.tools));
  }
  verdict.Add(JudgeRest(scene));
  std::fputs(MovedLines(scene).c_str(), stdout);
  Conclude(arguments.scene, verdict);
}

void Render(const Arguments& arguments) {
  if (!arguments.output.ends_with(".png")) {
    throw UsageError("-o " + arguments.output +
                     ": pictures are PNG; give a name that ends in .png");
  }
  if (arguments.whole) {
    DrawWhole(Load(arguments), arguments.output);
  } else {
    DrawScene(Load(arguments), arguments.level, arguments.output);
  }
  std::printf("wrote %s\n", arguments.output.c_str());
}

void WriteText(const std::string& file, const std::string& text) {
  WriteFileAtomically(file, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

void List() {
  for (const CatalogueEntry& entry : ListCatalogue()) {
    std::printf("%-16s  %s\n", entry.name.c_str(), entry.description.c_str());
  }
}

/// Never overwrites a file: somebody may have worked on it.
void New(const Arguments& arguments) {
  namespace fs = std::filesystem;
  if (fs::exists(arguments.output)) {
    throw Error(arguments.output + ": exists already; give another -o, or remove the file first");
  }
  const MeshScene scene = MakeMeshScene(arguments.scene, arguments.mesh,
                                        fs::path(arguments.output).parent_path().string());
  WriteText(arguments.output, scene.text);
  for (const std::string& assumption : scene.assumptions) std::puts(Printable(assumption).c_str());
  std::printf("wrote %s; serve it with: palpate-server --scene %s\n",
              Printable(arguments.output).c_str(), ShellWord(arguments.output).c_str());
}

void AddToleranceOptions(const CommandLine& app, std::optional<LeafTolerance>& leaves) {
  const auto sets = [&leaves](LeafTolerance::Of of, double unit) {
    return [&leaves, of, unit](double value) {
      leaves = LeafTolerance{.of = of, .most = unit * value};
    };
  };
  const Option um =
      app.AddNumber("--tolerance-um", sets(LeafTolerance::Of::kHeight, 1e-6),
                    "choose the number of leaves so that 95 % of their surface lies within this "
                    "distance of "
                    "the mesh, in um; overrides the scene file, except for a tool of one leaf")
          .Range(kLeastTolerance_um, kMostTolerance_um);
  app.AddNumber(
         "--tolerance-deg", sets(LeafTolerance::Of::kLean, M_PI / 180.0),
         "choose the number of leaves so that the mean error in the direction of the contact "
         "force is at most this, in degrees")
      .Range(kLeastTolerance_deg, kMostTolerance_deg)
      .Excludes(um);
}

/// Adds a command about a scene or a mesh, with what all of these have.
CommandLine AddSceneCommand(const CommandLine& app, Arguments& arguments, const char* name,
                            const char* help, const std::string& scene_help,
                            const std::string& example) {
  const CommandLine command = app.AddCommand(name, help);
  command.Footer("Example: palpate-scene " + std::string(name) + " " + example);
  command.Add("NAME", arguments.scene, scene_help).Required();
  command.AddFlag("--rebuild", arguments.rebuild, "build the scene again, without using the cache");
  return command;
}

std::string SceneHelp() {
  return "scene: a file, or one of " + Joined(CatalogueNames());
}

void AddBuild(const CommandLine& app, Arguments& arguments) {
  const CommandLine build =
      AddSceneCommand(app, arguments, "build", "build a scene into the cache, and into a bundle",
                      SceneHelp(), "bunny-bunny -o bunny.palpate");
  build.Add("-o,--output", arguments.output, "bundle to write (.palpate)");
  build
      .Add("--mode", arguments.mode,
           "how the leaves of all trees approximate their meshes; overrides the scene file")
      .OneOf({kTreeModes.begin(), kTreeModes.end()});
  AddToleranceOptions(build, arguments.leaves);
  build.Run([&] { Build(arguments); });
}

void AddInfo(const CommandLine& app, Arguments& arguments) {
  AddSceneCommand(app, arguments, "info",
                  "print features, bodies, materials, sizes, hash and tree errors of a scene\n"
                  "Tree errors are the distances of each level of each tree from its mesh.",
                  SceneHelp(), "bunny-bunny")
      .Run([&] { Info(arguments); });
}

void AddCheck(const CommandLine& app, Arguments& arguments) {
  AddSceneCommand(app, arguments, "check",
                  "check meshes, and how well the spheres cover them; ends with a verdict",
                  SceneHelp() + "; or a mesh file", "tooth.stl")
      .Run([&] { Check(arguments); });
}

void AddRender(const CommandLine& app, Arguments& arguments) {
  const CommandLine render =
      AddSceneCommand(app, arguments, "render", "draw mesh and spheres of every level as a PNG",
                      SceneHelp(), "bunny-bunny -o bunny.png");
  render.Add("-o,--output", arguments.output, "picture to write (.png)").Required();
  const Option level =
      render.Add("--level", arguments.level, "draw only this level, counted from 1");
  render.AddFlag("--whole", arguments.whole, "draw the whole scene instead of its bodies")
      .Excludes(level);
  render.Run([&] { Render(arguments); });
}

void AddNew(const CommandLine& app, Arguments& arguments) {
  const CommandLine make =
      AddSceneCommand(app, arguments, "new",
                      "write a scene file for a mesh, with a ball as the tool, for you to edit",
                      "mesh: OBJ, STL, PLY, 3DS or glTF", "tooth.stl -o tooth.json");
  make.Add("-o,--output", arguments.output, "scene file to write (.json)").Required();
  AddMeshOptions(make, arguments.mesh);
  make.Run([&] { New(arguments); });
}

int Main(int argc, char** argv) {
  const CommandLine app(
      "Compiles scenes: reads meshes, builds their sphere trees, and caches the result\n"
      "or writes it as a bundle, which the server loads at once.  NAME is a scene of\n"
      "the catalogue, a scene file (.json), a bundle (.palpate), or a mesh, to which a\n"
      "ball is added as the tool.",
      "palpate-scene",
      "Examples:\n"
      "  palpate-scene list\n"
      "  palpate-scene new tooth.stl -o tooth.json\n"
      "  palpate-scene build bunny-bunny -o bunny.palpate\n"
      "  palpate-scene build tooth.stl --tolerance-um 50\n"
      "  palpate-scene render bunny.palpate -o bunny.png\n"
      "'palpate-scene COMMAND --help' explains a command.");
  Arguments arguments;
  app.RequireCommands(1, 1);
  app.Fallthrough();
  app.Add("--models", arguments.models, "folder in which to look for model files first");
  app.Add("--cache", arguments.cache, "cache folder; default: ~/.cache/palpate");
  AddEffectsOption(app);
  AddCommonOptions(app, "accepted for consistency, but not used: this program does not communicate",
                   arguments.domain, arguments.log_level);
  app.BeforeCommands([&] { SetUpLog("palpate-scene", arguments.log_level); });

  AddBuild(app, arguments);
  AddInfo(app, arguments);
  AddCheck(app, arguments);
  AddRender(app, arguments);
  AddNew(app, arguments);
  const CommandLine list = app.AddCommand("list", "list the scenes of the catalogue");
  list.Footer("Example: palpate-scene list");
  list.Run(List);
  ParseCommandLine(app, argc, argv);
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-scene", [&] { return palpate::Main(argc, argv); });
}
